#pragma once

#include <string>
#include <vector>

#include "app/guard/run_marker.h"
#include "app/guard/stop_socket.h"

namespace skein::app {

/// Stops the robots of a run whatever state it is in: asks it through its stop socket; where it does not answer, ends
/// its process with SIGTERM and then SIGKILL, and asks its guard. What became of the robots; `by_hand`: nobody of them
/// is left who could stop them, so that they must be connected to.
struct StoppedRun {
  std::vector<StopResult> robots;
  bool by_hand = false;
};
StoppedRun stop_run(const RunMarker& run);

/// Stops the robots of runs that ended badly, through their guards or by a connection, and forgets each run whose
/// robots are known to stand. True: all of them.
bool stop_left_behind(const std::vector<RunMarker>& runs);

/// `skein stop`: STOP to every run of this user that lives and to every guard, at once; says what became of their
/// robots. An exit status.
int stop_runs();

/// `skein robots forget`: guards that go on trying give up, and runs that ended badly are not spoken of again. An exit
/// status.
int forget_runs();

}  // namespace skein::app
