// A camera whose time stamps make every pose too old to drive by, in whole runs.
#include <gmock/gmock.h>

#include "tests/app/session/rendered_platoon.h"

namespace skein::app {
namespace {

using test::RenderedPlatoon;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(CameraStamps, ThatAreTooOldToDriveByAreTheReasonThatIsTold) {
  const RenderedPlatoon run(3.0, {"camera.latency=0.3"});
  for (const TickRecord& row : run.sink.rows)
    for (const RobotRecord& robot : row.robots) EXPECT_EQ(robot.wheels.left, 0.0) << "nobody has driven";
  EXPECT_TRUE(run.down) << "the check list and the status line show it";
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("0.30 s old when they arrive, by their time stamps and camera.latency")));
}

TEST(CameraStamps, AreNotSpokenOfWhereRobotsDriveByThem) {
  const RenderedPlatoon run(3.0, {"camera.latency=0.1"});
  EXPECT_THAT(run.told, IsEmpty());
  EXPECT_FALSE(run.down);
}

}  // namespace
}  // namespace skein::app
