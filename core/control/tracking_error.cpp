#include "core/control/tracking_error.h"

#include "core/math/elementary.h"

namespace skein::core {

TrackingError tracking_error(const Pose& reference, const Pose& pose) noexcept {
  const double dx = reference.x - pose.x;
  const double dy = reference.y - pose.y;
  const auto [s, c] = math::sincos(pose.theta);
  return {c * dx + s * dy, -s * dx + c * dy, wrap_angle(reference.theta - pose.theta)};
}

TrackingError error_rate(const TrackingError& error, const Twist& reference, const Twist& command) noexcept {
  const auto [sin, cos] = math::sincos(error.theta);
  return {command.omega * error.y + reference.v * cos - command.v, -command.omega * error.x + reference.v * sin,
          reference.omega - command.omega};
}

}  // namespace skein::core
