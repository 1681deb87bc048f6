// Latency compensation: a late measurement, carried along the commands given since, is where the robot is.
#include "core/estimation/predictor.h"

#include <algorithm>
#include <vector>

#include "core/kinematics/unicycle.h"
#include "core/simulation/simulated_robot.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Measurement;
using core::Pose;
using core::Predictor;
using core::SimulatedRobot;
using core::Twist;

TEST(Predictor, FindsWhereARandomlyDrivenRobotIs) {
  holds("an old pose plus the commands since is the true pose", [] {
    Draw draw(any_seed());
    SimulatedRobot robot({}, core::MotorModel::ideal, {}, 1, 0);
    robot.place(draw.pose(1.0));
    Predictor predictor;
    std::vector<Measurement> history;
    double now = draw.between(0.0, 1e5);  // a session's clock need not start at zero
    const int ticks = draw.whole(1, 120);
    for (int k = 0; k < ticks; ++k) {
      history.push_back({robot.pose(), now});
      robot.command({draw.between(-1000.0, 1000.0), draw.between(-1000.0, 1000.0)});
      predictor.command(now, robot.twist());
      const double dt = draw.between(0.0, 0.08);  // ticks come early and late
      robot.step(dt);
      now += dt;
    }
    // Any capture that the memory of 64 commands still covers, also one between two ticks.
    const std::size_t newest = history.size() - 1;
    const std::size_t age = std::min<std::size_t>(newest, static_cast<std::size_t>(draw.whole(0, 63)));
    const Pose predicted = predictor.predict(history[newest - age], now);
    // 64 arcs of a few roundings; `now` itself is only known to 1.5e-11 s at 1e5 s, at 0.13 m/s and 5 rad/s.
    RC_ASSERT(core::distance(predicted, robot.pose()) <= 64 * 0.15 * 3e-11 + 64 * 5 * 1.5e-11);
    RC_ASSERT(std::abs(core::wrap_angle(predicted.theta - robot.pose().theta)) <= 64 * 5 * 3e-11);
  });
}

TEST(Predictor, SplitsACommandAtACaptureBetweenTwoTicks) {
  Predictor predictor;
  const Twist first{0.1, 0.5}, second{0.05, -1.0};
  predictor.command(1.0, first);
  predictor.command(1.04, second);
  const Pose at_capture{0.2, 0.1, 0.3};
  const Pose predicted = predictor.predict({at_capture, 1.03}, 1.07);
  const Pose expected = core::advance(core::advance(at_capture, first, 1.04 - 1.03), second, 1.07 - 1.04);
  EXPECT_EQ(predicted, expected);
}

TEST(Predictor, ReturnsAFreshPoseBitForBit) {
  holds("age zero (or less): the measurement itself", [] {
    Draw draw(any_seed());
    Predictor predictor;
    double now = draw.between(0.0, 1e4);
    const int commands = draw.whole(0, 200);
    for (int k = 0; k < commands; ++k, now += 0.04)
      predictor.command(now, {draw.between(-0.1, 0.1), draw.between(-2.0, 2.0)});
    const Pose pose = draw.pose(3.0);
    const double captured = now - draw.between(0.0, 1.0);
    RC_ASSERT(predictor.predict({pose, captured}, captured) == pose);
    RC_ASSERT(predictor.predict({pose, now + 1.0}, now) == pose);
  });
}

TEST(Predictor, LeavesThePoseAloneWithoutCommands) {
  const Predictor predictor;
  const Pose pose{1.0, 2.0, 3.0};
  EXPECT_EQ(predictor.predict({pose, 0.0}, 100.0), pose);
}

TEST(Predictor, CarriesOnWithTheLastCommand) {
  // A robot without a watchdog keeps its last speed for ever; so does the prediction.
  Predictor predictor;
  predictor.command(0.0, {0.05, 0.0});
  const Pose predicted = predictor.predict({{0.0, 0.0, 0.0}, 1.0}, 11.0);
  EXPECT_NEAR(predicted.x, 0.5, 1e-12);
}

TEST(Predictor, CountsTheTimeBeforeItsMemoryAsStandingStill) {
  Predictor predictor;
  for (int k = 0; k < 300; ++k) predictor.command(0.04 * k, {0.1, 0.0});
  // 256 commands reach back to that of 0.04 * 44.
  const Pose predicted = predictor.predict({{0.0, 0.0, 0.0}, 0.0}, 12.0);
  EXPECT_NEAR(predicted.x, 0.1 * (12.0 - 0.04 * 44), 1e-12);
  EXPECT_FALSE(predictor.remembers(0.04 * 43));
  EXPECT_TRUE(predictor.remembers(0.04 * 44));
  EXPECT_EQ(predictor.forgets_next()->from, 0.04 * 44);
}

TEST(Predictor, TakesTheLaterOfTwoCommandsForOneTime) {
  Predictor predictor;
  predictor.command(1.0, {0.1, 0.0});
  predictor.command(1.0, {-0.1, 0.0});
  EXPECT_NEAR(predictor.predict({{}, 1.0}, 2.0).x, -0.1, 1e-15);
}

}  // namespace
}  // namespace skein::test
