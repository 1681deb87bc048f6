#pragma once

#include <memory>

#include "app/experiment/experiment.h"
#include "app/tick/couplings.h"
#include "app/tick/tick_input.h"
#include "core/controllers/controller.h"

namespace skein::app {

struct TickState;

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
  /// Between the two, where the run has a controller of its own: what that is to be asked at this tick, valid until the
  /// next call of `see`. Null where the tick does not need it. Its answer goes into the input of `decide`.
  const core::ControllerInput* ask() noexcept;
  const TickRecord& decide(const TickInput& input) noexcept;

  /// The time of the experiment that the next tick will have, if `elapsed` ticks pass until then. [s]
  double next_time(int elapsed) const noexcept;

  /// The couplings as they are, and where they are going.
  const Couplings& couplings() const noexcept;

  const TickRecord& record() const noexcept;  ///< of the latest tick

 private:
  std::unique_ptr<TickState> state_;
};

}  // namespace skein::app
