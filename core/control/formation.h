#pragma once

#include "core/geometry/pose.h"

namespace skein::core {

/// (37) with (35): how much too close (positive) or too far apart (negative) two robots are, relative to their
/// references. [m]
inline double formation_error(const Pose& reference_i, const Pose& reference_j, const Pose& pose_i,
                              const Pose& pose_j) noexcept {
  return distance(reference_i, reference_j) - distance(pose_i, pose_j);
}

}  // namespace skein::core
