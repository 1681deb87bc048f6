#include "core/kinematics/unicycle.h"

#include "core/math/elementary.h"

namespace skein::core {

double sinc(double a) noexcept {
  // sin(a)/a = 1 - a^2/6 + a^4/120 - ...; below this size the next term is under half a unit in the last place.
  constexpr double series_below = 1e-3;
  const double a2 = a * a;
  if (std::abs(a) < series_below) return 1.0 - a2 / 6.0 * (1.0 - a2 / 20.0);
  return math::sin(a) / a;
}

Pose advance(const Pose& pose, const Twist& twist, double dt) noexcept {
  // The chord of an arc that turns by 2h has length v dt sinc(h) and the direction theta + h.
  const double half_turn = 0.5 * twist.omega * dt;
  const double chord = twist.v * dt * sinc(half_turn);
  const double direction = pose.theta + half_turn;
  const auto [sin, cos] = math::sincos(direction);
  return {pose.x + chord * cos, pose.y + chord * sin, wrap_angle(pose.theta + twist.omega * dt)};
}

}  // namespace skein::core
