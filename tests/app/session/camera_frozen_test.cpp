// A camera that repeats one picture with new time stamps, in whole runs.
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/rows.h"

namespace skein::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The paper's platoon in rendered pictures.
struct FrozenRun {
  explicit FrozenRun(std::vector<std::string> sets) {
    for (const char* set : {"camera.source=synthetic", "duration=6", "perturb=[]", "expect={}"}) sets.emplace_back(set);
    auto session = Session::open(good(paper_experiment().source, sets), Session::Clock::virtual_, {false, {&sink}});
    EXPECT_TRUE(session) << session.error();
    const auto listen = [&] {
      for (std::string& sentence : (*session)->alarms()) told.push_back(std::move(sentence));
      down = down || !(*session)->camera_status().down.empty();
      return true;
    };
    end = (*session)->run(listen);
    listen();
    outages = (*session)->camera().outages;
    (*session)->close();
  }
  /// Robots whose wheels are commanded to turn, at time t.
  int driving(double t) const {
    for (const TickRecord& row : sink.rows) {
      if (row.t < t) continue;
      int driving = 0;
      for (const RobotRecord& robot : row.robots)
        driving += robot.wheels.left != 0.0 || robot.wheels.right != 0.0 ? 1 : 0;
      return driving;
    }
    return -1;
  }
  test::Rows sink;
  Phase end = Phase::ready;
  std::vector<std::string> told;
  bool down = false;
  std::int64_t outages = 0;
};

TEST(CameraFrozen, StopsTheRobotsAfterTheBridgeTimeAndTheOperatorIsTold) {
  const FrozenRun run({"camera.freeze_at=2"});
  EXPECT_EQ(run.driving(1.9), 4);
  EXPECT_EQ(run.driving(2.0 + EstimationSpec{}.bridge + 0.08), 0);
  EXPECT_EQ(run.driving(5.9), 0);
  EXPECT_TRUE(run.down) << "the check list and the status line show it";
  EXPECT_EQ(run.outages, 1);
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("it delivers the same picture again and again")));
}

TEST(CameraFrozen, RobotsGoOnWhenThePictureChangesAgain) {
  const FrozenRun run({"camera.freeze_at=2", "camera.freeze_for=1"});
  EXPECT_EQ(run.driving(2.9), 0);
  EXPECT_EQ(run.driving(3.5), 4);
  EXPECT_THAT(run.told, ElementsAre(HasSubstr("the same picture"), HasSubstr("delivers new pictures again")));
  for (const RobotRecord& robot : run.sink.rows.back().robots)
    EXPECT_LT(core::distance(robot.measurement.pose, robot.truth), 0.001);
}

TEST(CameraFrozen, ASingleRepeatedFrameIsNoMatter) {
  const FrozenRun run({"camera.freeze_at=2", "camera.freeze_for=0.05"});
  EXPECT_THAT(run.told, IsEmpty());
  EXPECT_EQ(run.driving(2.2), 4);
}

TEST(CameraFrozen, IsNotSaidOfACameraThatIsNot) {
  const FrozenRun run({});
  EXPECT_THAT(run.told, IsEmpty());
  EXPECT_FALSE(run.down);
  EXPECT_EQ(run.outages, 0);
}

}  // namespace
}  // namespace skein::app
