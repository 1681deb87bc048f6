#pragma once

#include <functional>

namespace skein::app {

enum class Aside {
  behind,  ///< at a lower priority than the window
  beside,  ///< at the same one: robots wait for it
};

/// Runs work that may hang, such as that of a camera's driver, on a thread of its own, and does not wait for it:
/// the caller may be gone by the time it ends. The end of the program waits two seconds for all of it. The work throws
/// nothing, and uses only what it owns.
void run_aside(std::function<void()> work, Aside priority = Aside::behind);

/// Waits until all work aside has ended. False: some still runs after `patience` [s].
bool aside_is_over(double patience);

}  // namespace skein::app
