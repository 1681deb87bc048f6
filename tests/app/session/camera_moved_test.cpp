// The camera is bumped in the middle of a run: the robots stop and the operator is told why, since every pose is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/rows.h"
#include "tests/app/session/expect_stop.h"

namespace skein::app {
namespace {

using test::Rows;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double bump_time = 3.0;

/// The paper's platoon as a rendered camera sees it, bumped by a degree while it drives.
Experiment bumped_platoon(const Sets& more = {}) {
  Sets sets{"camera.source=synthetic", "camera.bump_at=3", "duration=6", "perturb=[]", "expect={}"};
  sets.insert(sets.end(), more.begin(), more.end());
  return good(paper_experiment().source, sets);
}

struct BumpedRun {
  explicit BumpedRun(const Experiment& experiment) {
    CsvWriter file(csv, experiment);
    auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&file, &sink}});
    EXPECT_TRUE(session) << session.error();
    end = (*session)->run();
    told = (*session)->alarms();
    (*session)->close();
    failure = (*session)->failure().value_or("");
  }
  Rows sink;
  std::ostringstream csv;
  Phase end = Phase::ready;
  std::string failure;
  std::vector<std::string> told;
};

/// The least and the largest error of a measured pose that was taken from then on. [m]
std::pair<double, double> errors_from(const BumpedRun& run, double since) {
  double least = 1e9, most = 0.0;
  for (const TickRecord& row : run.sink.rows)
    for (const RobotRecord& robot : row.robots) {
      if (robot.measurement.captured_at < row.now - 1e-9 || row.now < since) continue;
      const double error = core::distance(robot.measurement.pose, robot.truth);
      least = std::min(least, error);
      most = std::max(most, error);
    }
  return {least, most};
}

TEST(CameraMoved, ABumpOfOneDegreeStopsTheRobotsAndTheOperatorIsToldWhy) {
  const BumpedRun run(bumped_platoon());
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("the camera moved (or the floor under it): all 4 tags moved by 41 mm"));
  EXPECT_NE(run.csv.str().find("camera_moved tags=4 by=0.041"), std::string::npos);
  EXPECT_EQ(run.sink.count<events::CameraMoved>(), 1);
  ASSERT_FALSE(run.sink.rows.empty());
  const TickRecord& last = run.sink.rows.back();
  test::expect_stop(last);
  EXPECT_LE(last.now, bump_time + 0.12) << "three frames of 40 ms at most";
  EXPECT_LT(errors_from(run, 0.0).first, 1e-3);
}

TEST(CameraMoved, TheSameRunGoesOnByWrongPosesWhereTheFileSaysSo) {
  const BumpedRun run(bumped_platoon({"failure.camera_moved=go_on"}));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_EQ(run.failure, "");
  EXPECT_EQ(run.sink.count<events::CameraMoved>(), 1) << "it is said all the same, once";
  const auto [least, most] = errors_from(run, bump_time);
  EXPECT_GT(least, 0.0405);
  EXPECT_LT(most, 0.0425);
}

TEST(CameraMoved, ACameraThatIsRaisedStopsTheRobotsAndTheOperatorIsToldWhy) {
  const BumpedRun run(bumped_platoon({"camera.bump=0", "camera.raise=0.05"}));
  EXPECT_EQ(run.end, Phase::stopped);
  EXPECT_THAT(run.failure, HasSubstr("all 4 tags look 2."));
  EXPECT_THAT(run.failure, HasSubstr("% smaller at once: STOP"));
  EXPECT_EQ(run.sink.count<events::CameraMoved>(), 1);
  EXPECT_NE(run.csv.str().find("camera_moved tags=4 by=0 turn=0 scale=-0.02"), std::string::npos);
  ASSERT_FALSE(run.sink.rows.empty());
  EXPECT_LE(run.sink.rows.back().now, bump_time + 0.3);
}

/// Two robots that drive to and fro on a line each.
Experiment bumped_pair(const Sets& more) {
  const std::string pair =
      "[reference]\nkind = \"independent\"\n"
      "[[robot]]\ntag = 1\n"
      "trajectory = { path = { shape = \"line\", from = [-0.3, 0.3], to = [0.3, 0.3] }, speed = 0.08 }\n"
      "[[robot]]\ntag = 2\n"
      "trajectory = { path = { shape = \"line\", from = [0.4, -0.3], to = [-0.4, -0.3] }, speed = 0.08 }\n";
  Sets sets{"camera.source=synthetic", "camera.bump_at=3", "camera.bump=0", "duration=6"};
  sets.insert(sets.end(), more.begin(), more.end());
  return good(pair, sets);
}

TEST(CameraMoved, ACameraThatIsRaisedIsKnownByTwoRobotsAlone) {
  for (const char* raise : {"camera.raise=0.05", "camera.raise=-0.05"}) {
    const BumpedRun run(bumped_pair({raise}));
    EXPECT_EQ(run.end, Phase::stopped) << raise;
    EXPECT_THAT(run.failure, HasSubstr("all 2 tags look 2."));
    EXPECT_EQ(run.sink.count<events::CameraMoved>(), 1);
    ASSERT_FALSE(run.sink.rows.empty());
    EXPECT_LE(run.sink.rows.back().now, bump_time + 1.3);
    test::expect_stop(run.sink.rows.back());
  }
}

TEST(CameraMoved, OneThatSlipsByAFewMillimetresIsToldAndTheRunGoesOn) {
  const BumpedRun run(bumped_platoon({"camera.bump=0", "camera.raise=-0.016"}));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_FALSE(run.sink.has<events::CameraMoved>());
  EXPECT_THAT(run.told, Contains(HasSubstr("larger than a few seconds before: the camera hangs lower")));
}

TEST(CameraMoved, IsReplayedBitForBit) {
  for (const char* then : {"failure.camera_moved=all_stop", "failure.camera_moved=go_on"}) {
    const BumpedRun run(bumped_platoon({then}));
    std::istringstream csv(run.csv.str());
    const auto result = replay(csv, "run.csv");
    ASSERT_TRUE(result) << result.error();
    EXPECT_GT(result->commands, 0);
    EXPECT_EQ(result->different, 0) << then << ": " << result->first;
  }
}

TEST(CameraMoved, ABumpWhileTheRunIsPausedIsKnownAsWell) {
  const Experiment experiment = bumped_platoon();
  Rows sink;
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&sink}});
  ASSERT_TRUE(session) << session.error();
  int asked = 0;
  const Phase end = (*session)->run([&] {
    if (asked++ == 2) {
      EXPECT_TRUE((*session)->pause());
    }  // after 32 ticks, before the bump
    return asked < 100;
  });
  EXPECT_EQ(end, Phase::stopped);
  EXPECT_THAT((*session)->failure().value_or(""), HasSubstr("the camera moved"));
  EXPECT_LT(asked, 100) << "not the test has stopped it";
}

/// Control of the others: what happens to robots is no bump.
TEST(CameraMoved, RobotsThatAreCarriedKickedAndMovedTogetherAreNoBump) {
  const BumpedRun run(bumped_platoon({"camera.bump_at=1000",
                                      "perturb=[{t=1,robot=2,dx=0.03,dy=-0.15},{t=2,robot=1,dx=0.05,dy=0.05},"
                                      "{t=2,robot=2,dx=0.05,dy=0.05},{t=2,robot=3,dx=0.05,dy=0.05},"
                                      "{t=2,robot=4,dx=0.05,dy=0.05}]",
                                      "operator=[{t=4,does=\"kick r3 vx=0.3 vy=0.2\"}]"}));
  EXPECT_EQ(run.failure, "");
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_FALSE(run.sink.has<events::CameraMoved>());
}

TEST(CameraMoved, OfOneRobotAloneNobodyKnowsAndAKidnapIsSaid) {
  const std::string one =
      "[reference]\nkind = \"independent\"\n[[robot]]\ntag = 1\n"
      "trajectory = { path = { shape = \"line\", from = [-0.3, 0.0], to = [0.3, 0.0] }, speed = 0.08 }\n";
  const BumpedRun run(good(one, {"camera.source=synthetic", "camera.bump_at=3", "duration=5"}));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_FALSE(run.sink.has<events::CameraMoved>());
  EXPECT_TRUE(run.sink.has<events::Kidnap>());
}

TEST(CameraMoved, OfOneRobotAloneThatLooksSmallerBothReasonsAreSaid) {
  const std::string one =
      "[reference]\nkind = \"independent\"\n[[robot]]\ntag = 1\n"
      "trajectory = { path = { shape = \"line\", from = [-0.3, 0.0], to = [0.3, 0.0] }, speed = 0.08 }\n";
  const BumpedRun run(
      good(one, {"camera.source=synthetic", "camera.bump_at=3", "camera.bump=0", "camera.raise=0.05", "duration=6"}));
  EXPECT_EQ(run.end, Phase::finished);
  EXPECT_TRUE(run.sink.rows.back().robots[0].is(lost)) << "and stands";
  EXPECT_EQ(run.sink.rows.back().robots[0].wheels.left, 0.0);
  EXPECT_THAT(run.told, Contains(HasSubstr("or the camera or its zoom has moved")));
}

}  // namespace
}  // namespace skein::app
