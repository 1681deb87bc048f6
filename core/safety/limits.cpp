#include "core/safety/limits.h"

#include <algorithm>
#include <cmath>

namespace skein::core {

double CommandLimits::omega_limit() const noexcept {
  return std::min(omega_max, 2.0 * drive.max_wheel_speed() / drive.track);
}

double CommandLimits::v_limit(double omega) const noexcept {
  return std::clamp(drive.max_wheel_speed() - 0.5 * drive.track * std::abs(omega), 0.0, v_max);
}

CommandLimits::Biting CommandLimits::biting(const Twist& wanted) const noexcept {
  const double v = std::abs(wanted.v), omega = std::abs(wanted.omega);
  const double left = drive.max_wheel_speed() - 0.5 * drive.track * std::min(omega, omega_limit());
  return {v > v_max, omega > omega_max, v > std::max(0.0, left) || 0.5 * drive.track * omega > drive.max_wheel_speed()};
}

Twist CommandLimits::limit(const Twist& wanted) const noexcept {
  const double omega = std::clamp(wanted.omega, -omega_limit(), omega_limit());
  const double v = v_limit(omega);
  return {std::clamp(wanted.v, -v, v), omega};
}

}  // namespace skein::core
