#pragma once

#include <string>
#include <vector>

#include "app/guard/run_marker.h"
#include "app/guard/stop_socket.h"

namespace skein::app {

/// Stops the robots of a run whatever state it is in: asks it through its stop socket; if it does not answer, ends its
/// process with SIGTERM and then SIGKILL, and asks its guard, until all stand, comms::reach_patience() is over or the
/// user interrupts. A frozen guard is resumed; if that fails, it is ended. Returns the robots' states; `by_hand`:
/// neither run nor guard is left to stop them, so that the caller must connect to them.
struct StoppedRun {
  std::vector<StopResult> robots;
  bool by_hand = false;
};
StoppedRun stop_run(const RunMarker& run);

/// Stops the robots of runs that ended badly, through their guards or by a connection, and forgets each run whose
/// robots are known to stand. True: all of them.
bool stop_left_behind(const std::vector<RunMarker>& runs);

/// For a user who has seen that their robots stand: ends the guards of these runs, which keep trying, and forgets them.
void forget_left_behind(const std::vector<RunMarker>& runs);

/// `skein stop`: sends STOP to every active run of this user and to every guard, at once; prints the results for their
/// robots. Returns an exit status.
int stop_runs();

/// `skein robots forget`: ends guards that keep trying, and removes the markers of runs that ended badly. Returns an
/// exit status.
int forget_runs();

}  // namespace skein::app
