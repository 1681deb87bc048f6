#pragma once

#include <gtest/gtest.h>

#include "app/run/tick_record.h"

namespace skein::test {

/// STOP was said in this tick, and no robot's wheels are told to turn.
inline void expect_stop(const app::TickRecord& row) {
  EXPECT_TRUE(row.events.contains<app::events::Stop>());
  for (const app::RobotRecord& robot : row.robots) {
    EXPECT_EQ(robot.wheels.left, 0.0);
    EXPECT_EQ(robot.wheels.right, 0.0);
  }
}

}  // namespace skein::test
