#pragma once

namespace skein::app {

/// From now on SIGINT and SIGTERM only make `interrupted` true, and a reader of the program's output that has gone is a
/// write error (SIGPIPE is ignored).
void catch_interrupts() noexcept;

/// True from the first SIGINT or SIGTERM after `catch_interrupts` on. Any thread.
bool interrupted() noexcept;

}  // namespace skein::app
