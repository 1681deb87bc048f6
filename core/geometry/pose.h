#pragma once

#include <cmath>
#include <numbers>

#include "core/math/elementary.h"

namespace skein::core {

inline constexpr double pi = std::numbers::pi;

/// An angle wrapped to (-pi, pi]. [rad]
inline double wrap_angle(double angle) noexcept {
  // Most angles are wrapped already, and the remainder is slow.
  const double wrapped = std::abs(angle) <= pi ? angle : std::remainder(angle, 2.0 * pi);
  return wrapped <= -pi ? pi : wrapped;
}

/// Where a robot is in the world frame O-xy: x right, y up [m]; theta counter-clockwise from +x, in (-pi, pi] [rad].
struct Pose {
  double x = 0.0;
  double y = 0.0;
  double theta = 0.0;

  friend bool operator==(const Pose&, const Pose&) = default;
};

/// How a unicycle moves: forward velocity v [m/s], steering (turning) velocity omega [rad/s], counter-clockwise.
struct Twist {
  double v = 0.0;
  double omega = 0.0;

  friend bool operator==(const Twist&, const Twist&) = default;
};

/// The distance between two robots' midpoints. [m]
inline double distance(const Pose& a, const Pose& b) noexcept {
  return math::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace skein::core
