#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "app/couplings.h"
#include "app/experiment/experiment.h"
#include "app/operator_command.h"
#include "app/record/tick_record.h"

namespace skein::app {

/// Everything that a tick may know.
struct TickInput {
  double now = 0.0;   ///< session's clock [s]
  int elapsed = 1;    ///< ticks since the one before: 1, or more when deadlines were missed
  bool stop = false;  ///< STOP is latched
  std::span<const core::Measurement> measurements;  ///< the newest of each robot
  std::span<const core::Pose> truth;                ///< of each robot, NaN where unknown
  std::span<const double> delays;  ///< from each robot's command to its wheels, as measured [s]; empty: none
  std::span<const OperatorCommand> commands;
  EventList events;  ///< what the world reports: perturbations, moves, links
};

/// The control tick: measurements and the time in, wheel speeds and a full record out. No I/O, no waiting, no
/// allocation, no lock, no exception: the same code in the window, headless and in a replay.
class ControlTick {
 public:
  explicit ControlTick(const Experiment& experiment);
  ~ControlTick();

  /// One tick. The record is valid until the next call.
  const TickRecord& step(const TickInput& input) noexcept {
    see(input);
    return decide(input);
  }
  /// Its two parts, for whoever wants to know how long each takes: where the robots are, and what they shall do. Both
  /// with the same input.
  void see(const TickInput& input) noexcept;
  const TickRecord& decide(const TickInput& input) noexcept;

  /// The time of the experiment that the next tick will have, if `elapsed` ticks pass until then. [s]
  double next_time(int elapsed) const noexcept;

  /// The couplings as they are, and where they are going.
  const Couplings& couplings() const noexcept;

  const TickRecord& record() const noexcept;  ///< of the latest tick

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace skein::app
