#pragma once

#include <string_view>

#include "core/kinematics/differential_drive.h"

namespace skein::core {

/// How a robot's motors convert a commanded speed into steps.
enum class MotorModel {
  ideal,   ///< executes the law's command exactly, fractions of a step included (simulation only)
  epuck1,  ///< timer of 10 kHz: a step every floor(10000/|s|) ticks; clamps at 1000 steps/s
  epuck2,  ///< timer of 50 kHz: a step every floor(50000/|s|) ticks; clamps at 1100 steps/s
  servo,   ///< the robot's own controller keeps the wheel at the commanded speed, a whole number
};

/// As files call it (core/words.h).
constexpr std::string_view word(MotorModel motor) noexcept {
  switch (motor) {
    case MotorModel::ideal:
      return "ideal";
    case MotorModel::epuck1:
      return "epuck1";
    case MotorModel::epuck2:
      return "epuck2";
    case MotorModel::servo:
      return "servo";
  }
  return {};
}

/// Speed at which the motors' firmware clamps. [steps/s]
double max_step_rate(MotorModel motor) noexcept;

/// The real step rate of the motor for the command `commanded` (a whole number unless `ideal`). [steps/s]
double actual_step_rate(MotorModel motor, double commanded) noexcept;

/// The slowest speed commanded to a real motor [steps/s]: after a slower one an e-puck2 takes up to half a second to
/// obey (12 steps/s: 42 ms, one tick). Speeds between 0 and this one are made by alternating the two.
inline constexpr double slowest_command = 13.0;

/// The whole-number command, 0 or at least `slowest_command`, whose actual step rate is nearest to `wanted` (`wanted`
/// itself for an ideal motor). [steps/s]
double nearest_command(MotorModel motor, double wanted) noexcept;

}  // namespace skein::core
