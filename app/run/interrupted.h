#pragma once

namespace skein::app {

/// From now on SIGINT, SIGTERM, SIGHUP and whatever else would end the program without a word only make `interrupted`
/// true. A reader of the program's output that has gone, a file that has grown too large and a terminal that lets
/// nobody write are write errors.
void catch_interrupts() noexcept;

/// As if such a signal had come. Async-signal-safe.
void interrupt() noexcept;

/// True from the first such signal after `catch_interrupts` on. Any thread.
bool interrupted() noexcept;

}  // namespace skein::app
