#pragma once

#include <string>

namespace skein::app {

/// `skein guard MARKER`, started by a run (safety_net.h). Two duties:
/// - Watchdog: it holds duplicates of the descriptors of the robots' lines. While the run's threads fall silent it
/// writes
///   the stop on them, until they beat again.
/// - When the run is gone without having said that all is well, it writes the stop on the same lines at once, then
///   reaches every robot that has not acknowledged that anew, for as long as it takes, or until somebody says otherwise
///   (`skein robots forget`). Then it removes the marker.
/// `descriptor`: the run's end of what watchdog.h describes. An exit status.
int guard(const std::string& marker, int descriptor);

}  // namespace skein::app
