#pragma once

namespace skein::app {

/// From now on SIGINT, SIGTERM, SIGHUP and whatever else would end the program without a word only make `interrupted`
/// true. SIGTSTP (Ctrl-Z) does so as well where robots' lines are open, and stops the robots before it suspends the
/// program. A reader of the program's output that has gone, a file that has grown too large and a terminal that lets
/// nobody write are write errors.
void catch_interrupts() noexcept;

/// True from the first such signal after `catch_interrupts` on. Any thread.
bool interrupted() noexcept;

}  // namespace skein::app
