#pragma once

#include <string_view>

namespace skein::app {

/// Text for whoever reads stdout and stderr. None of this throws, and none of it waits for a reader or a disk longer
/// than `patience`: a terminal may be gone, stopped by Ctrl-S, or a full disk, and robots must be stopped all the same.
/// What cannot be written by then is written later if it can be, and dropped beyond 64 kB. Any thread.

inline constexpr double short_patience = 0.1;  // [s]

void print_out(std::string_view text, double patience = short_patience) noexcept;
void print_error(std::string_view text, double patience = short_patience) noexcept;

/// "skein: SENTENCE" and a line end, on stderr.
void complain(std::string_view sentence) noexcept;

/// Descriptors 0, 1 and 2 that are closed become /dev/null: else the next robot's line would be one of them, and get to
/// read what is meant for people. Before anything is opened.
void fill_standard_descriptors() noexcept;

}  // namespace skein::app
