#pragma once

#include <string_view>

namespace skein::app {

/// Output to stdout and stderr. These functions never throw, and never wait for a reader or a disk longer than
/// `patience`: a terminal may be closed or stopped by Ctrl-S, a disk may be full, and robots must still be stopped.
/// Text that cannot be written by then is written later if possible, and dropped beyond 64 kB. Any thread.
/// What a terminal would obey is escaped (terminal_text.h), on stdout only where that is a terminal: scripts get it as
/// it is.

inline constexpr double short_patience = 0.1;    // [s]
inline constexpr double reader_patience = 60.0;  // for what is read in a pager, while nothing drives [s]

void print_out(std::string_view text, double patience = short_patience) noexcept;
void print_error(std::string_view text, double patience = short_patience) noexcept;

/// As it is: for the program's own control sequences, and for what a user's own program says.
void print_error_as_is(std::string_view text, double patience = short_patience) noexcept;

/// "skein: SENTENCE" and a line end, on stderr; the sentence stays on its line.
void complain(std::string_view sentence) noexcept;
/// The same for what is several sentences, a line each, as Problem's message() returns them.
void complain_lines(std::string_view sentences) noexcept;

/// Waits until all text is written, at most `patience` in all [s]: for the program's end, when nothing drives.
void finish_output(double patience) noexcept;

/// Opens closed descriptors 0, 1 and 2 as /dev/null: otherwise the next robot's line would get one of them, and receive
/// the program's output. Call it before anything is opened.
void fill_standard_descriptors() noexcept;

}  // namespace skein::app
