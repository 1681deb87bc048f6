#include "core/control/tracking_error.h"

namespace skein::core {

TrackingError tracking_error(const Pose& reference, const Pose& pose) noexcept {
  const double dx = reference.x - pose.x;
  const double dy = reference.y - pose.y;
  const double c = std::cos(pose.theta);
  const double s = std::sin(pose.theta);
  return {c * dx + s * dy, -s * dx + c * dy, wrap_angle(reference.theta - pose.theta)};
}

TrackingError error_rate(const TrackingError& error, const Twist& reference, const Twist& command) noexcept {
  return {command.omega * error.y + reference.v * std::cos(error.theta) - command.v,
          -command.omega * error.x + reference.v * std::sin(error.theta), reference.omega - command.omega};
}

}  // namespace skein::core
