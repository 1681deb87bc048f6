#pragma once

#include <string>

namespace skein::app {

/// `skein guard`, started by a run (safety_net.h), with its marker (run_marker.h). It leaves the run's process tree,
/// and where there is a service manager its control group. Two duties:
/// - Watchdog: it holds duplicates of the descriptors of the robots' lines. While the run's threads stall it writes
///   the stop on them, until their heartbeats return.
/// - When the run ends without reporting that all robots stand, it writes the stop on the same lines at once, then
///   reconnects to every robot that has not acknowledged, for as long as it takes, or until `skein robots forget`. Then
///   it removes the marker.
/// `descriptor`: the run's socket of watchdog.h. Returns an exit status.
int guard(const std::string& marker, int descriptor);

}  // namespace skein::app
