#pragma once

#include <cmath>

#include "app/run/tick_record.h"

namespace skein::ui {

/// Where a robot is: a simulated one where it really is, any other where it is seen.
inline core::Pose place(const app::RobotRecord& robot) {
  return std::isfinite(robot.truth.x) ? robot.truth : robot.pose;
}

}  // namespace skein::ui
