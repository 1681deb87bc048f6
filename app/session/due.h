#pragma once

#include "core/geometry/pose.h"

namespace skein::app {

/// Whether what the file sets for the time `when` happens before the tick of time `t`. [s] It is due half a nanosecond
/// early, because t is a quotient and the file's number a decimal.
constexpr bool is_due(double when, double t) noexcept {
  return t >= when - 0.5e-9;
}

/// Where a perturbation, the file's or the event, puts a robot that is `here`.
template <typename P>
core::Pose perturbed(const core::Pose& here, const P& perturbation) noexcept {
  return {here.x + perturbation.dx, here.y + perturbation.dy, core::wrap_angle(here.theta + perturbation.dtheta)};
}

}  // namespace skein::app
