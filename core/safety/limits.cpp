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

Twist CommandLimits::limit(const Twist& wanted) const noexcept {
  const double omega = std::clamp(wanted.omega, -omega_limit(), omega_limit());
  const double v = v_limit(omega);
  return {std::clamp(wanted.v, -v, v), omega};
}

}  // namespace skein::core
