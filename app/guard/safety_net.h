#pragma once

#include <chrono>
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

/// Stops the robots when the program dies or freezes: a marker (run_marker.h), `skein guard` (guard.h), a separate
/// process, the stop socket through which other programs stop the run, and a delay of the machine's suspend and
/// shutdown until the robots stand. A thread supervises them: when the guard dies or freezes, a new one is started
/// within a second. Move-only.
class SafetyNet {
 public:
  struct Run {
    std::string name;                        ///< of the experiment
    std::vector<comms::LinkAddress> robots;  ///< real ones; none: only the stop socket
    std::string program{};                   ///< what to start as `program guard MARKER`; empty: this program itself
    double guard_begins_within = 20.0;       ///< or it is replaced; enough for a very slow machine [s]
  };
  /// Waits for the guard to begin, up to 1 s. The error: the marker cannot be written, or the guard not started; the
  /// run can go on without.
  static tl::expected<SafetyNet, std::string> spread(const Run& run);
  SafetyNet();
  SafetyNet(SafetyNet&& other) noexcept;
  SafetyNet& operator=(SafetyNet&& other) noexcept;
  ~SafetyNet();  ///< without done(): as if the program had died

  /// What stops the robots. `why`: a sentence for the operator.
  using Stop = std::function<void(const std::string& why)>;
  /// Sets the action of an external STOP, by another program or before the machine is suspended or shut down, and the
  /// query for the robots' states after it. Both are called on the net's thread, until done() or until empty functions
  /// are set. A STOP that came before is executed at once.
  void on_stop(Stop stop, std::function<std::vector<StopResult>()> results);
  /// Sentences about what has happened to the guard since the last call. Any thread.
  std::vector<std::string> alarms();
  /// The process of the present guard; -1: none, or it has not begun yet. Any thread.
  pid_t guard_process() const;

  /// The run is over. If a robot has not acknowledged its stop, the guard keeps trying, and the marker stays. `robots`:
  /// those of the experiment, in its order.
  void done(const std::vector<StopResult>& robots);

 private:
  class Keeper;
  std::unique_ptr<Keeper> keeper_;
};

/// The sentence for the operator when no safety net could be set up, with the reason.
std::string unguarded_sentence(const std::string& why);

/// The address of a real robot of an experiment, with the name from robot_name().
tl::expected<comms::LinkAddress, std::string> link_of(const Experiment& experiment, std::size_t robot);

/// The addresses of the real robots of an experiment, likewise. The error names the robot: its address is wrong, or
/// leads to another one of them, also by another name of its host; blocks on the name service.
tl::expected<std::vector<comms::LinkAddress>, std::string> real_robots(const Experiment& experiment);

/// The states of the real robots of an experiment after the run.
std::vector<StopResult> stop_results(const Experiment& experiment, const std::vector<RobotStatus>& robots);

/// Connects to one of these robots and stops it, waiting long enough for an adapter that has to page all of them.
/// Ends early when the user interrupts. Empty: it has acknowledged its stop; else the reason. `still_tries`: called
/// once if that takes longer than `silent_for`, with what it waits for.
std::string stop_one(const std::vector<comms::LinkAddress>& robots, std::size_t robot,
                     const std::function<void(const std::string& reason)>& still_tries = {});
inline constexpr auto silent_for = std::chrono::seconds(1);
/// Says so of a robot on stderr.
void complain_of_waiting(const std::string& address, const std::string& reason);

/// Connects to all of them at the same time, stops each, and prints each result on stdout or stderr as soon as it is
/// known, and after `silent_for` whom it waits for. True: all are known to stand.
bool stop_all(const std::vector<comms::LinkAddress>& robots);

}  // namespace skein::app
