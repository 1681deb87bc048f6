#pragma once

#include <memory>

#include "app/experiment/experiment.h"
#include "app/tick/couplings.h"
#include "app/tick/tick_input.h"
#include "core/controllers/controller.h"
#include "core/estimation/camera_fusion.h"

namespace skein::app {

struct TickState;

/// The control tick: its inputs are measurements and the time, its outputs wheel speeds and a full record. No I/O, no
/// waiting, no allocation, no lock, no exception: the same code in the window, headless and in a replay.
class ControlTick {
 public:
  explicit ControlTick(const Experiment& experiment);
  ~ControlTick();

  /// Forgets its own state and continues from the state of `other`, a tick of the same experiment: the same inputs give
  /// the same bits. Not part of a tick.
  void go_on_from(const ControlTick& other);

  /// One tick. The record is valid until the next call.
  const TickRecord& step(const TickInput& input) noexcept {
    see(input);
    return decide(input);
  }
  /// Its two parts, so that each can be timed: estimation of the poses, and computation of the commands. Both with the
  /// same input.
  void see(const TickInput& input) noexcept;
  /// Between the two, if the run has a controller of its own: the question to it at this tick, valid until the next
  /// call of `see`. Null if the tick does not need it. Its answer goes into the input of `decide`.
  const core::ControllerInput* ask() noexcept;
  const TickRecord& decide(const TickInput& input) noexcept;

  /// The time of the experiment that the next tick will have, if `elapsed` ticks pass until then. [s]
  double next_time(int elapsed) const noexcept;

  /// The present couplings and their targets.
  const Couplings& couplings() const noexcept;

  /// What two cameras say of each other. first < second.
  const core::CameraFusion::Comparison& compared(std::size_t first, std::size_t second) const noexcept;

  const TickRecord& record() const noexcept;  ///< of the latest tick

 private:
  std::unique_ptr<TickState> state_;
};

}  // namespace skein::app
