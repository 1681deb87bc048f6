#pragma once

namespace skein::app {

/// The errno with which output on stdout was lost; 0: nothing was lost, or only because its reader went away (`|
/// head`). Printing goes on regardless of that, since robots matter more: ask at the end, when the C library's buffer
/// is flushed as well.
int output_error() noexcept;

}  // namespace skein::app
