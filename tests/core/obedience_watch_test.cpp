// Whether a robot does what it is commanded to, seen from its poses alone.
#include "core/safety/obedience_watch.h"

#include <gtest/gtest.h>

#include "core/simulation/simulated_robot.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Imperfection;
using core::Measurement;
using core::ObedienceWatch;
using core::PoseFilter;
using core::SimulatedRobot;
using core::WheelSpeeds;

/// A robot, its filter, and who watches it. The wheels are commanded, and turn, as told here.
struct Watched {
  explicit Watched(const Imperfection& imperfection = {}, std::uint64_t seed = 1)
      : robot({}, core::MotorModel::ideal, imperfection, seed, 0) {}

  /// A tick: the robot is seen, commanded so, and its wheels turn so. True: whether it disobeys has changed.
  bool tick(const WheelSpeeds& commanded, const WheelSpeeds& turns) {
    const Measurement measured = robot.measure(now);
    filter.see({}, measured);
    const bool changed = watch.see(
        {.now = now, .to_wheel = 0.0265, .kidnap = 0.02, .blind_way = blind_way, .judged = judged}, filter, measured);
    filter.command(now, core::DifferentialDrive{}.twist(commanded));
    robot.command(turns);
    robot.step(dt);
    now += dt;
    return changed;
  }
  /// Number of ticks after which whether it disobeys has changed; 0: it has not.
  int changes_within(int ticks, const WheelSpeeds& commanded, const WheelSpeeds& turns) {
    for (int k = 1; k <= ticks; ++k)
      if (tick(commanded, turns)) return k;
    return 0;
  }

  SimulatedRobot robot;
  PoseFilter filter;
  ObedienceWatch watch;
  double now = 0.0, blind_way = 0.0;
  bool judged = true;
};

constexpr WheelSpeeds ahead{600.0, 600.0}, turning{-300.0, 300.0}, standing{};

TEST(ObedienceWatch, AccusesNobodyWhoDrivesAsCommandedOverNoiseAndSlip) {
  holds("neither disobeys nor stuck", [] {
    Draw draw(any_seed());
    Imperfection poor;
    poor.pose_noise = draw.between(0.0, 0.001), poor.heading_noise = draw.between(0.0, 0.01);
    poor.slip = 0.03, poor.dropout = 0.05;
    Watched robot(poor, static_cast<std::uint64_t>(draw.whole(1, 1 << 30)));
    WheelSpeeds wheels;
    for (int k = 0; k < 250; ++k) {
      if (k % 25 == 0) wheels = {draw.between(-700.0, 700.0), draw.between(-700.0, 700.0)};
      RC_ASSERT(!robot.tick(wheels, wheels));
      RC_ASSERT(!robot.watch.stuck());
    }
  });
}

TEST(ObedienceWatch, OneThatDrivesThoughCommandedToStandDisobeysUntilItStands) {
  Watched robot;
  EXPECT_EQ(robot.changes_within(25, standing, standing), 0);
  const int noticed = robot.changes_within(25, standing, ahead);
  EXPECT_TRUE(0 < noticed && noticed <= 10) << noticed;
  EXPECT_TRUE(robot.watch.disobeys());
  EXPECT_GT(robot.watch.motion()->v, ObedienceWatch::too_slow);
  EXPECT_EQ(robot.changes_within(50, standing, ahead), 0);  // nothing new
  const int obeyed = robot.changes_within(25, standing, standing);
  EXPECT_TRUE(0 < obeyed && obeyed <= 10) << obeyed;
  EXPECT_FALSE(robot.watch.disobeys());
}

TEST(ObedienceWatch, OneThatTurnsTheOtherWayDisobeys) {
  Watched robot;
  EXPECT_GT(robot.changes_within(25, turning, {300.0, -300.0}), 0);
  EXPECT_TRUE(robot.watch.disobeys());
}

TEST(ObedienceWatch, OneThatStandsThoughCommandedToDriveIsStuckAndDoesNotDisobey) {
  for (const WheelSpeeds& commanded : {ahead, turning}) {
    Watched robot;
    EXPECT_EQ(robot.changes_within(25, commanded, standing), 0);
    EXPECT_TRUE(robot.watch.stuck());
    robot.changes_within(10, standing, standing);
    EXPECT_TRUE(robot.watch.stuck()) << "told to stand, it shows nothing";
    robot.changes_within(10, commanded, commanded);
    EXPECT_FALSE(robot.watch.stuck());
  }
}

TEST(ObedienceWatch, BelievesThatWhatWasNotConfirmedMayNotHaveBeenHeard) {
  Watched robot;
  robot.blind_way = 0.05;
  EXPECT_EQ(robot.changes_within(25, ahead, standing), 0);
  EXPECT_FALSE(robot.watch.stuck());
}

TEST(ObedienceWatch, JudgesNobodyWhomAHandMoves) {
  // Carried along at the speed of a hand, announced or while nobody drives.
  for (const bool announced : {true, false}) {
    Watched robot;
    robot.judged = announced;
    if (announced) robot.watch.excuse(2.0);
    for (int k = 0; k < 40; ++k) {
      robot.robot.place({0.004 * k, 0.0, 0.0});
      EXPECT_FALSE(robot.tick(standing, standing));
    }
    EXPECT_TRUE(robot.watch.motion());
  }
  // Put elsewhere in one tick: nothing is known of its motion until it has been seen often enough from there.
  Watched robot;
  robot.changes_within(10, standing, standing);
  ASSERT_TRUE(robot.watch.motion());
  robot.robot.place({0.3, 0.0, 0.0});
  EXPECT_EQ(robot.changes_within(4, standing, standing), 0);
  EXPECT_FALSE(robot.watch.motion());
}

}  // namespace
}  // namespace skein::test
