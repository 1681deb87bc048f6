#pragma once

#include "core/kinematics/differential_drive.h"

namespace skein::core {

/// The limits of one robot: the box (14) and its wheels, which form a diamond |v| + |omega| track/2 <= wheel limit.
struct CommandLimits {
  double v_max = 0.1;      ///< (14) [m/s]
  double omega_max = 1.7;  ///< (14) [rad/s]
  DifferentialDrive drive;

  /// The largest turning rate that box and wheels allow. [rad/s]
  double omega_limit() const noexcept;
  /// The largest forward speed that box and wheels allow at this turning rate. [m/s]
  double v_limit(double omega) const noexcept;
  /// Which limits reduce a requested twist: the box for v, the box for omega, the wheels.
  struct Biting {
    bool v = false, omega = false, wheels = false;
  };
  Biting biting(const Twist& wanted) const noexcept;
  /// The twist clamped to box and diamond, signs kept. The turning rate has priority: it keeps the robot on its path,
  /// and the forward speed gets the rest of the wheels' speed.
  Twist limit(const Twist& wanted) const noexcept;
};

}  // namespace skein::core
