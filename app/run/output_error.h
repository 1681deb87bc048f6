#pragma once

namespace skein::app {

/// Why something that was printed on stdout was lost, as errno; 0: nothing was, or only its reader went away (`|
/// head`). Printing goes on regardless of that, since robots matter more: ask at the end, when the C library's buffer
/// is flushed as well.
int output_error() noexcept;

}  // namespace skein::app
