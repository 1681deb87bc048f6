#pragma once

#include <array>

#include "core/controllers/controller.h"

namespace skein::core {

/// Saturated tracking of one robot by itself: (15) with every coupling at zero and the normaliser of its own position
/// error alone. The authority of the couplings goes to tracking: k_x and k_theta are the whole remainder of (14) after
/// the reference, unless the gains are fixed.
Twist track_alone(const Gains& gains, std::size_t i, const TrackingError& error, const Twist& reference) noexcept;

/// Each robot separately: the group is one copy of the same law per robot.
class IndependentController final : public Controller {
 public:
  explicit IndependentController(std::size_t) {}
  void step(const ControllerInput& input, std::span<Twist> command, std::span<double>) noexcept override {
    for (std::size_t i = 0; i < command.size(); ++i)
      command[i] = track_alone(*input.gains, i, input.errors[i], input.reference_twists[i]);
  }
};

}  // namespace skein::core
