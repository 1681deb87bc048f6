#include "core/kinematics/differential_drive.h"

namespace skein::core {

WheelSpeeds DifferentialDrive::wheels(const Twist& twist) const noexcept {
  const double half = 0.5 * track * twist.omega, share = unlike();
  return {(twist.v - half) / (metres_per_step() * (1.0 - share)),
          (twist.v + half) / (metres_per_step() * (1.0 + share))};
}

Twist DifferentialDrive::twist(const WheelSpeeds& wheels) const noexcept {
  // With wheels that are alike `share` is 0, and these are the textbook's, bit for bit.
  const double sum = wheels.right + wheels.left, difference = wheels.right - wheels.left, share = unlike();
  return {0.5 * metres_per_step() * (sum + share * difference), metres_per_step() * (difference + share * sum) / track};
}

}  // namespace skein::core
