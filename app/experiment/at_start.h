#pragma once

#include "app/experiment/experiment.h"
#include "core/geometry/pose.h"

namespace skein::app {

/// How close to its start a robot counts as being there.
struct StartTolerance {
  double distance;  ///< [m]
  double heading;   ///< [rad]
};

/// Before a run: the law corrects the remaining error smoothly.
constexpr StartTolerance start_tolerance(const StagingSpec& staging) noexcept {
  return {staging.within, 0.2};
}
/// For staging, which continues until all robots are well inside the tolerance of the run.
inline constexpr StartTolerance staged_tolerance{0.012, 0.05};

/// Whether a robot stands at its start. An unknown pose (NaN) does not count as away.
inline bool at_start(const core::Pose& pose, const core::Pose& start, const StartTolerance& tolerance) noexcept {
  return !(core::distance(pose, start) > tolerance.distance) &&
         !(std::abs(core::wrap_angle(pose.theta - start.theta)) > tolerance.heading);
}

}  // namespace skein::app
