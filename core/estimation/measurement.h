#pragma once

#include "core/geometry/pose.h"

namespace skein::core {

/// The newest pose that was measured of one robot, by a camera or a simulation.
struct Measurement {
  Pose pose;  ///< in the world frame
  double captured_at =
      -1e9;  ///< when the robot stood there, on the session's monotonic clock [s]; far past: never seen
};

}  // namespace skein::core
