#pragma once

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "core/geometry/pose.h"

namespace skein::app {

/// Whether what the file sets for the time `when` happens before the tick of time `t`. [s] It is due half a nanosecond
/// early, because t is a quotient and the file's number a decimal.
constexpr bool is_due(double when, double t) noexcept {
  return t >= when - 0.5e-9;
}

/// Whether the file may do something before the tick of time `t`: in a run, but not in the tick that ends it, whose
/// poses are those of the end. [s]
inline bool may_act(const Experiment& experiment, Phase phase, double t) noexcept {
  return phase == Phase::running && !is_due(static_cast<double>(experiment.ticks()) / experiment.rate, t);
}

/// Where a perturbation, the file's or the event, puts a robot that is `here`.
template <typename P>
core::Pose perturbed(const core::Pose& here, const P& perturbation) noexcept {
  return {here.x + perturbation.dx, here.y + perturbation.dy, core::wrap_angle(here.theta + perturbation.dtheta)};
}

}  // namespace skein::app
