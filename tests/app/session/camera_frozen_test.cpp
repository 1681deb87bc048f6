// A camera that repeats one picture with new time stamps, in whole runs.
#include <gmock/gmock.h>

#include "tests/app/session/rendered_platoon.h"

namespace skein::app {
namespace {

using test::RenderedPlatoon;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Robots whose wheels are commanded to turn, at time t.
int driving(const RenderedPlatoon& run, double t) {
  for (const TickRecord& row : run.sink.rows) {
    if (row.t < t) continue;
    int driving = 0;
    for (const RobotRecord& robot : row.robots)
      driving += robot.wheels.left != 0.0 || robot.wheels.right != 0.0 ? 1 : 0;
    return driving;
  }
  return -1;
}

TEST(CameraFrozen, StopsTheRobotsAfterTheBridgeTimeAndTheOperatorIsTold) {
  const RenderedPlatoon run(6.0, {"camera.freeze_at=2"});
  EXPECT_EQ(driving(run, 1.9), 4);
  EXPECT_EQ(driving(run, 2.0 + EstimationSpec{}.bridge + 0.08), 0);
  EXPECT_EQ(driving(run, 5.9), 0);
  EXPECT_TRUE(run.down) << "the check list and the status line show it";
  EXPECT_EQ(run.outages, 1);
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("it delivers the same picture again and again")));
}

TEST(CameraFrozen, RobotsGoOnWhenThePictureChangesAgain) {
  const RenderedPlatoon run(6.0, {"camera.freeze_at=2", "camera.freeze_for=1"});
  EXPECT_EQ(driving(run, 2.9), 0);
  EXPECT_EQ(driving(run, 3.5), 4);
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("the same picture"), HasSubstr("delivers new pictures again")));
  for (const RobotRecord& robot : run.sink.rows.back().robots)
    EXPECT_LT(core::distance(robot.measurement.pose, robot.truth), 0.001);
}

/// A transfer that breaks off in the middle of every frame: the tags in the upper half are seen as before.
TEST(CameraFrozen, IsSaidOfALowerHalfAloneAndNobodyDrivesByIt) {
  const RenderedPlatoon run(6.0, {"camera.freeze_at=2", "camera.freeze_for=1", "camera.freeze_part=0.5"});
  EXPECT_EQ(driving(run, 1.9), 4);
  EXPECT_EQ(driving(run, 2.0 + EstimationSpec{}.bridge + 0.08), 0);
  EXPECT_EQ(driving(run, 2.9), 0);
  EXPECT_EQ(driving(run, 3.5), 4);
  EXPECT_TRUE(run.down);
  EXPECT_EQ(run.outages, 1);
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("50 % of its picture show what older ones showed"),
                                    HasSubstr("delivers new pictures again")));
  for (const RobotRecord& robot : run.sink.rows.back().robots)
    EXPECT_LT(core::distance(robot.measurement.pose, robot.truth), 0.001);
}

TEST(CameraFrozen, ASingleRepeatedFrameIsNoMatter) {
  const RenderedPlatoon run(6.0, {"camera.freeze_at=2", "camera.freeze_for=0.05"});
  EXPECT_THAT(run.told, IsEmpty());
  EXPECT_EQ(driving(run, 2.2), 4);
}

TEST(CameraFrozen, IsNotSaidOfACameraThatIsNot) {
  const RenderedPlatoon run(6.0);
  EXPECT_THAT(run.told, IsEmpty());
  EXPECT_FALSE(run.down);
  EXPECT_EQ(run.outages, 0);
}

}  // namespace
}  // namespace skein::app
