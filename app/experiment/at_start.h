#pragma once

#include "app/experiment/experiment.h"
#include "core/geometry/pose.h"

namespace skein::app {

/// How near to its start a robot stands that counts as standing there.
struct StartTolerance {
  double distance;  ///< [m]
  double heading;   ///< [rad]
};

/// Of a run that is about to begin: the law brings in the rest without a lurch.
constexpr StartTolerance start_tolerance(const StagingSpec& staging) noexcept {
  return {staging.within, 0.2};
}
/// Of staging, which goes on until everybody stands well inside the tolerance of the run.
inline constexpr StartTolerance staged_tolerance{0.012, 0.05};

/// Whether a robot stands at its start. A pose that is not known (NaN) is not away from it.
inline bool at_start(const core::Pose& pose, const core::Pose& start, const StartTolerance& tolerance) noexcept {
  return !(core::distance(pose, start) > tolerance.distance) &&
         !(std::abs(core::wrap_angle(pose.theta - start.theta)) > tolerance.heading);
}

}  // namespace skein::app
