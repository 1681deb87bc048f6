#pragma once

#include <cmath>

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
  double wheel_diameter = 0.041;  ///< the mean of both [m]; 0.040 to 0.041 among real robots: calibrate
  double track = 0.053;           ///< distance between the wheels' contact points [m]
  double steps_per_turn = 1000;   ///< motor steps for one turn of a wheel
  double max_step_rate = 1000;    ///< the fastest a motor runs [steps/s]: e-puck1 1000, e-puck2 1100
  double wheel_ratio = 1.0;       ///< the right wheel's diameter over the left one's

  double left_diameter() const noexcept { return wheel_diameter * (1.0 - unlike()); }   ///< [m]
  double right_diameter() const noexcept { return wheel_diameter * (1.0 + unlike()); }  ///< [m]
  void set_diameters(double left, double right) noexcept {                              ///< [m]
    wheel_diameter = 0.5 * (left + right);
    wheel_ratio = right / left;
  }

  /// Way of the robot for one motor step of both wheels. [m]
  double metres_per_step() const noexcept { return pi * wheel_diameter / steps_per_turn; }
  /// The fastest that both wheels' rims move. [m/s]
  double max_wheel_speed() const noexcept { return max_step_rate * metres_per_step() * (1.0 - std::abs(unlike())); }

  /// The wheel speeds that give a twist, not limited, not rounded.
  WheelSpeeds wheels(const Twist& twist) const noexcept;
  /// The twist that wheel speeds give.
  Twist twist(const WheelSpeeds& wheels) const noexcept;

 private:
  /// How far each wheel is from the mean, as a share of it; exactly 0 where both are alike.
  double unlike() const noexcept { return (wheel_ratio - 1.0) / (wheel_ratio + 1.0); }
};

}  // namespace skein::core
