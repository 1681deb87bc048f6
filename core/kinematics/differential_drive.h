#pragma once

#include <cmath>

#include "core/geometry/pose.h"

namespace skein::core {

/// Wheel speeds in the e-puck's unit, motor steps per second; positive drives forward.
/// A command is a pair of whole numbers; a motor's real rate need not be whole (see step_rate.h).
struct WheelSpeeds {
  double left = 0.0;
  double right = 0.0;

  friend bool operator==(const WheelSpeeds&, const WheelSpeeds&) = default;
};

/// The dimensions of a differential drive. Defaults: the e-puck's, see CONVENTIONS.md.
struct DifferentialDrive {
  double wheel_diameter = 0.041;  ///< the mean of both [m]; real robots have 0.040 to 0.041: calibrate
  double track = 0.053;           ///< distance between the wheels' contact points [m]
  double steps_per_turn = 1000;   ///< motor steps for one turn of a wheel
  double max_step_rate = 1000;    ///< largest rate of a motor [steps/s]: e-puck1 1000, e-puck2 1100
  double wheel_ratio = 1.0;       ///< the right wheel's diameter over the left one's

  double left_diameter() const noexcept { return wheel_diameter * (1.0 - unlike()); }   ///< [m]
  double right_diameter() const noexcept { return wheel_diameter * (1.0 + unlike()); }  ///< [m]
  void set_diameters(double left, double right) noexcept {                              ///< [m]
    wheel_diameter = 0.5 * (left + right);
    wheel_ratio = right / left;
  }

  /// Distance per motor step of both wheels. [m]
  double metres_per_step() const noexcept { return pi * wheel_diameter / steps_per_turn; }
  /// The largest speed of the wheels' rims. [m/s]
  double max_wheel_speed() const noexcept { return max_step_rate * metres_per_step() * (1.0 - std::abs(unlike())); }

  /// The wheel speeds for a twist, neither limited nor rounded.
  WheelSpeeds wheels(const Twist& twist) const noexcept;
  /// The twist from wheel speeds.
  Twist twist(const WheelSpeeds& wheels) const noexcept;

 private:
  /// The deviation of each wheel from the mean, as a share of it; exactly 0 for equal wheels.
  double unlike() const noexcept { return (wheel_ratio - 1.0) / (wheel_ratio + 1.0); }
};

}  // namespace skein::core
