#pragma once

#include "core/geometry/pose.h"

namespace skein::core {

/// sin(a)/a, smooth at 0, where it is 1 (16, 17).
double sinc(double a) noexcept;

/// The exact solution of the unicycle kinematics (1) after `dt` seconds of constant `twist`: an arc, or a straight line
/// where omega is 0, with no loss of accuracy between the two.
Pose advance(const Pose& pose, const Twist& twist, double dt) noexcept;

}  // namespace skein::core
