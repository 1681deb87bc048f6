#pragma once

#include "core/geometry/pose.h"
#include "core/kinematics/differential_drive.h"

namespace skein::core {

/// A differential drive whose wheels need not be alike.
struct TwoWheels {
  double left_diameter = 0.041, right_diameter = 0.041;  ///< [m]
  double track = 0.053;                                  ///< [m]
  double steps_per_turn = 1000;

  TwoWheels() = default;
  explicit TwoWheels(const DifferentialDrive& drive) noexcept
      : left_diameter(drive.wheel_diameter),
        right_diameter(drive.wheel_diameter),
        track(drive.track),
        steps_per_turn(drive.steps_per_turn) {}

  /// Way of a wheel for one motor step. [m]
  double left_step() const noexcept { return pi * left_diameter / steps_per_turn; }
  double right_step() const noexcept { return pi * right_diameter / steps_per_turn; }
  double ratio() const noexcept { return right_diameter / left_diameter; }

  WheelSpeeds wheels(const Twist& twist) const noexcept {
    const double half = 0.5 * track * twist.omega;
    return {(twist.v - half) / left_step(), (twist.v + half) / right_step()};
  }
  Twist twist(const WheelSpeeds& wheels) const noexcept {
    const double left = left_step() * wheels.left, right = right_step() * wheels.right;
    return {0.5 * (left + right), (right - left) / track};
  }
};

}  // namespace skein::core
