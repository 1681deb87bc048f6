#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/guard/stop_socket.h"
#include "app/run/status.h"
#include "comms/link_address.h"

namespace skein::app {

/// What catches the robots when the program dies or freezes: a marker (run_marker.h), `skein guard` (guard.h), a
/// process of its own, and the stop socket through which anybody stops the run. A thread looks after them: when the
/// guard dies or freezes there is a new one within a second. Move-only.
class SafetyNet {
 public:
  struct Run {
    std::string name;                        ///< of the experiment
    std::vector<comms::LinkAddress> robots;  ///< real ones; none: only the stop socket
    std::string program{};                   ///< what to start as `program guard MARKER`; empty: this program itself
  };
  /// The error: the marker cannot be written, or the guard not started; the run can go on without.
  static tl::expected<SafetyNet, std::string> spread(const Run& run);
  SafetyNet();
  SafetyNet(SafetyNet&& other) noexcept;
  SafetyNet& operator=(SafetyNet&& other) noexcept;
  ~SafetyNet();  ///< without done(): as if the program had died

  /// What STOP from outside does, and how the robots are then. Both are called on the net's thread, until done() or
  /// nothing is given. A STOP that came before is carried out at once.
  void on_stop(std::function<void()> stop, std::function<std::vector<StopResult>()> results);
  /// Sentences about what has happened to the guard since the last call. Any thread.
  std::vector<std::string> alarms();
  /// The process that guards now; -1: none does. Any thread.
  pid_t guard_process() const;

  /// The run is over. Where a robot has not acknowledged its stop, the guard goes on trying, and the marker stays.
  /// `robots`: those of the experiment, in its order.
  void done(const std::vector<StopResult>& robots);

 private:
  class Keeper;
  std::unique_ptr<Keeper> keeper_;
};

/// How a real robot of an experiment is reached, named as robot_name() says.
tl::expected<comms::LinkAddress, std::string> link_of(const Experiment& experiment, std::size_t robot);

/// The real robots of an experiment, named likewise. The error names the robot.
tl::expected<std::vector<comms::LinkAddress>, std::string> real_robots(const Experiment& experiment);

/// How the real robots of an experiment are after the run.
std::vector<StopResult> stop_results(const Experiment& experiment, const std::vector<RobotStatus>& robots);

/// Connects to one of these robots and stops it, with patience for an adapter that has to page all of them. Empty: it
/// has acknowledged its stop; else why not.
std::string stop_one(const std::vector<comms::LinkAddress>& robots, std::size_t robot);

/// Connects to each, at the same time, stops it, and says on stdout and stderr how that went. True: all are known to
/// stand.
bool stop_all(const std::vector<comms::LinkAddress>& robots);

}  // namespace skein::app
