#pragma once

#include "core/geometry/pose.h"

namespace skein::core {

/// A robot's reference at one time: pose and velocities (2, 3).
struct ReferencePoint {
  Pose pose;
  Twist twist;

  friend bool operator==(const ReferencePoint&, const ReferencePoint&) = default;
};

/// The tracking error of (4), in the ROBOT's frame: x ahead, y to its left [m]; theta in (-pi, pi] [rad].
struct TrackingError {
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;
};

/// (4): the reference seen from the robot.
TrackingError tracking_error(const Pose& reference, const Pose& pose) noexcept;

/// (5a): the time derivative of the tracking error when the robot moves with `command`.
TrackingError error_rate(const TrackingError& error, const Twist& reference, const Twist& command) noexcept;

}  // namespace skein::core
