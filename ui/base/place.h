#pragma once

#include <cmath>

#include "app/run/tick_record.h"

namespace skein::ui {

/// Where a robot is: the true place of a simulated one, the measured place of any other.
inline core::Pose place(const app::RobotRecord& robot) {
  return std::isfinite(robot.truth.x) ? robot.truth : robot.pose;
}

}  // namespace skein::ui
