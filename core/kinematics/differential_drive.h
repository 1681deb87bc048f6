#pragma once

#include "core/geometry/pose.h"

namespace skein::core {

/// Wheel speeds in the e-puck's unit, motor steps per second; positive drives forward.
/// A command is a pair of whole numbers; what a motor really runs need not be (see step_rate.h).
struct WheelSpeeds {
  double left = 0.0;
  double right = 0.0;

  friend bool operator==(const WheelSpeeds&, const WheelSpeeds&) = default;
};

/// The measures of a differential drive. Defaults: the e-puck's, see CONVENTIONS.md.
struct DifferentialDrive {
  double wheel_diameter = 0.041;  ///< [m]; 0.040 to 0.041 among real robots: calibrate
  double track = 0.053;           ///< distance between the wheels' contact points [m]
  double steps_per_turn = 1000;   ///< motor steps for one turn of a wheel
  double max_step_rate = 1000;    ///< the fastest a motor runs [steps/s]: e-puck1 1000, e-puck2 1100

  /// Way of a wheel for one motor step. [m]
  double metres_per_step() const noexcept { return pi * wheel_diameter / steps_per_turn; }
  /// The fastest a wheel's rim moves. [m/s]
  double max_wheel_speed() const noexcept { return max_step_rate * metres_per_step(); }

  /// The wheel speeds that give a twist, not limited, not rounded.
  WheelSpeeds wheels(const Twist& twist) const noexcept;
  /// The twist that wheel speeds give.
  Twist twist(const WheelSpeeds& wheels) const noexcept;
};

}  // namespace skein::core
