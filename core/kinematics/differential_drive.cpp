#include "core/kinematics/differential_drive.h"

namespace skein::core {

WheelSpeeds DifferentialDrive::wheels(const Twist& twist) const noexcept {
  const double half = 0.5 * track * twist.omega;
  return {(twist.v - half) / metres_per_step(), (twist.v + half) / metres_per_step()};
}

Twist DifferentialDrive::twist(const WheelSpeeds& wheels) const noexcept {
  return {0.5 * metres_per_step() * (wheels.right + wheels.left),
          metres_per_step() * (wheels.right - wheels.left) / track};
}

}  // namespace skein::core
