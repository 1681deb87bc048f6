// The simulated robot: repeatable to the bit, and each fault of its localisation by the measure asked for.
#include "core/simulation/simulated_robot.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "core/kinematics/unicycle.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::DifferentialDrive;
using core::Imperfection;
using core::Measurement;
using core::MotorModel;
using core::Pose;
using core::SimulatedRobot;

constexpr Imperfection every_fault{0.003, 0.02, 0.08, 0.1, 0.05};

struct Trace {
  std::vector<Pose> truth;
  std::vector<Measurement> measured;
};

Trace drive(std::uint64_t seed, std::uint64_t stream, const Imperfection& imperfection, int ticks = 200) {
  SimulatedRobot robot({}, MotorModel::epuck1, imperfection, seed, stream);
  Trace trace;
  for (int k = 0; k < ticks; ++k) {
    trace.measured.push_back(robot.measure(dt * k));
    robot.command({300.0 + k, 500.0 - 2.0 * k});
    robot.step(dt);
    trace.truth.push_back(robot.pose());
  }
  return trace;
}

bool same(const Trace& a, const Trace& b) {
  return a.truth == b.truth &&
         std::equal(a.measured.begin(), a.measured.end(), b.measured.begin(), b.measured.end(),
                    [](const auto& m, const auto& o) { return m.pose == o.pose && m.captured_at == o.captured_at; });
}

TEST(SimulatedRobot, RepeatsItselfBitForBit) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    EXPECT_TRUE(same(drive(seed, 3, every_fault), drive(seed, 3, every_fault)));
    EXPECT_FALSE(same(drive(seed, 3, every_fault), drive(seed + 1, 3, every_fault)));
    EXPECT_FALSE(same(drive(seed, 3, every_fault), drive(seed, 4, every_fault)));
  }
}

TEST(SimulatedRobot, SlipsTheSameWayWhateverItsLocalisationSuffers) {
  // The floor's randomness and the camera's are streams of their own: a study of one does not change the other.
  Imperfection slip_only{.slip = 0.05};
  EXPECT_EQ(drive(5, 0, slip_only).truth, drive(5, 0, every_fault).truth);
}

TEST(SimulatedRobot, RunsTheRatesItsMotorsHave) {
  SimulatedRobot robot({}, MotorModel::epuck1, {}, 1, 0);
  robot.command({700.0, 910.0});
  EXPECT_NEAR(robot.wheels().left, 714.3, 0.05);
  EXPECT_EQ(robot.wheels().right, 1000.0);
  const Pose before = robot.pose();
  robot.step(0.5);
  const Pose ahead = core::advance(before, DifferentialDrive{}.twist(robot.wheels()), 0.5);
  EXPECT_NEAR(robot.pose().x, ahead.x, 1e-9);
  EXPECT_NEAR(robot.pose().y, ahead.y, 1e-9);
  EXPECT_NEAR(robot.pose().theta, ahead.theta, 1e-9);
  robot.step(0.5);  // and they go on: no watchdog
  EXPECT_GT(robot.pose().x, 0.05);
}

TEST(SimulatedRobot, OfIdealMakeIsWhereTheArcsLead) {
  SimulatedRobot robot({}, MotorModel::ideal, {}, 1, 0);
  robot.place({0.3, -0.1, 2.0});
  Pose expected = robot.pose();
  for (int k = 0; k < 100; ++k) {
    robot.command({100.5 + k, 350.25 - k});
    robot.step(dt);
    expected = core::advance(expected, DifferentialDrive{}.twist({100.5 + k, 350.25 - k}), dt);
    EXPECT_EQ(robot.pose(), expected);
    const Measurement seen = robot.measure(dt * (k + 1));
    EXPECT_EQ(seen.pose, robot.pose());
    EXPECT_EQ(seen.captured_at, dt * (k + 1));
  }
}

TEST(SimulatedRobot, DeliversPosesWholeTicksLate) {
  for (int late = 0; late <= 62; ++late)
    for (const double rate : {25.0, 30.0, 60.0}) {
      SimulatedRobot robot({}, MotorModel::ideal, {.latency = late / rate}, 1, 0);
      robot.command({200.0, 260.0});
      std::vector<Pose> stood_at;
      for (int k = 0; k < 200; ++k) {
        const double now = k / rate;
        stood_at.push_back(robot.pose());
        const Measurement newest = robot.measure(now);
        if (k < late) {
          ASSERT_LT(newest.captured_at, -1e8) << "nothing has arrived yet";
        } else {
          ASSERT_EQ(newest.captured_at, (k - late) / rate) << "rate " << rate << ", late by " << late << ", dt " << k;
          ASSERT_EQ(newest.pose, stood_at[static_cast<std::size_t>(k - late)]);
        }
        robot.step(1.0 / rate);
      }
    }
}

TEST(SimulatedRobot, RoundsALatencyBetweenTicksUp) {
  SimulatedRobot robot({}, MotorModel::ideal, {.latency = 1.5 * dt}, 1, 0);
  for (int k = 0; k < 50; ++k) {
    const Measurement newest = robot.measure(dt * k);
    if (k >= 2) {
      ASSERT_EQ(newest.captured_at, dt * (k - 2));
    }
  }
}

TEST(SimulatedRobot, LosesTheShareOfMeasurementsAskedFor) {
  constexpr int count = 20000;
  for (const double dropout : {0.0, 0.05, 0.3, 0.9, 1.0}) {
    SimulatedRobot robot({}, MotorModel::ideal, {.dropout = dropout}, 9, 0);
    int fresh = 0;
    for (int k = 0; k < count; ++k) fresh += robot.measure(dt * k).captured_at == dt * k;
    // Five standard deviations of a binomial count.
    EXPECT_NEAR(fresh, (1.0 - dropout) * count, 5.0 * std::sqrt(dropout * (1.0 - dropout) * count)) << dropout;
  }
}

TEST(SimulatedRobot, KeepsTheLastPoseWhileMeasurementsAreLost) {
  SimulatedRobot robot({}, MotorModel::ideal, {.latency = 0.08, .dropout = 0.5}, 2, 0);
  robot.command({300.0, 300.0});
  std::vector<Pose> stood_at;
  double last = -1e9;
  for (int k = 0; k < 1000; ++k) {
    stood_at.push_back(robot.pose());
    const Measurement newest = robot.measure(dt * k);
    ASSERT_GE(newest.captured_at, last) << "never an older pose after a newer one";
    ASSERT_LE(newest.captured_at, dt * k - 0.08 + 1e-9);
    if (newest.captured_at >= 0.0) {
      const auto captured = static_cast<std::size_t>(std::lround(newest.captured_at / dt));
      ASSERT_EQ(newest.pose, stood_at[captured]) << "pose and capture time belong together";
    }
    last = newest.captured_at;
    robot.step(dt);
  }
  EXPECT_GT(last, 900 * dt);
}

TEST(SimulatedRobot, AddsNoiseOfTheSizeAskedFor) {
  constexpr int count = 40000;
  SimulatedRobot robot({}, MotorModel::ideal, {.pose_noise = 0.002, .heading_noise = 0.03}, 4, 0);
  robot.place({0.5, -0.5, core::pi});  // on the seam of the headings
  double x = 0.0, y = 0.0, theta = 0.0, mean_x = 0.0, cross = 0.0;
  for (int k = 0; k < count; ++k) {
    const Pose seen = robot.measure(dt * k).pose;
    ASSERT_GT(seen.theta, -core::pi);
    ASSERT_LE(seen.theta, core::pi);
    const double dx = seen.x - 0.5, dy = seen.y + 0.5;
    x += dx * dx, y += dy * dy, theta += std::pow(core::wrap_angle(seen.theta - core::pi), 2);
    mean_x += dx, cross += dx * dy;
  }
  // The root mean square of n Gaussians is known to 1 / sqrt(2 n): 0.35 %; five of these.
  EXPECT_NEAR(std::sqrt(x / count), 0.002, 0.002 * 0.018);
  EXPECT_NEAR(std::sqrt(y / count), 0.002, 0.002 * 0.018);
  EXPECT_NEAR(std::sqrt(theta / count), 0.03, 0.03 * 0.018);
  EXPECT_NEAR(mean_x / count, 0.0, 5.0 * 0.002 / std::sqrt(count));
  EXPECT_NEAR(cross / count, 0.0, 5.0 * 4e-6 / std::sqrt(count));
  EXPECT_EQ(robot.pose(), (Pose{0.5, -0.5, core::pi})) << "the robot itself stands still";
}

TEST(SimulatedRobot, SlipsByTheShareAskedFor) {
  constexpr int count = 40000;
  SimulatedRobot robot({}, MotorModel::ideal, {.slip = 0.1}, 6, 0);
  robot.command({400.0, 400.0});
  const double way = 400.0 * DifferentialDrive{}.metres_per_step() * dt;
  double spread = 0.0, turn = 0.0;
  for (int k = 0; k < count; ++k) {
    robot.place({});
    robot.step(dt);
    spread += std::pow(robot.pose().x / way - 1.0, 2);
    turn += std::pow(robot.pose().theta, 2);
  }
  // Two wheels, each 10 %: the mean of both spreads by 10 % / sqrt(2), the difference over the track by sqrt(2) 10 %.
  EXPECT_NEAR(std::sqrt(spread / count), 0.1 / std::sqrt(2.0), 0.1 * 0.018);
  EXPECT_NEAR(std::sqrt(turn / count), std::sqrt(2.0) * 0.1 * way / 0.053, 0.018 * 0.142 * way / 0.053);
  SimulatedRobot still({}, MotorModel::ideal, {.slip = 0.1}, 6, 0);
  still.step(dt);
  EXPECT_EQ(still.pose(), Pose{}) << "wheels that stand do not slip";
}

TEST(SimulatedRobot, SlipsAndSeesIndependently) {
  // Slip and noise drawn from one and the same stream would be equal, number by number.
  constexpr int count = 10000;
  SimulatedRobot robot({}, MotorModel::ideal, {.pose_noise = 0.002, .slip = 0.1}, 8, 0);
  robot.command({400.0, 400.0});
  const double way = 400.0 * DifferentialDrive{}.metres_per_step() * dt;
  double product = 0.0;
  for (int k = 0; k < count; ++k) {
    robot.place({});
    robot.step(dt);
    const double slip = (robot.pose().x / way - 1.0) / (0.1 / std::sqrt(2.0));
    const double noise = (robot.measure(dt * k).pose.x - robot.pose().x) / 0.002;
    product += slip * noise;
  }
  EXPECT_NEAR(product / count, 0.0, 5.0 / std::sqrt(count));
}

TEST(SimulatedRobot, SlidesTheSameWayAfterAKickHoweverTimeIsCut) {
  const double speed = 0.5;
  const double way = speed * speed / (2.0 * SimulatedRobot::friction);
  for (const double dt : {0.04, 0.013, 0.001, 1.0}) {
    SimulatedRobot robot({}, MotorModel::ideal, {}, 1, 0);
    robot.place({0.1, 0.2, 1.0});
    robot.kick(0.6 * speed, -0.8 * speed);
    for (double t = 0.0; t < 1.0; t += dt) robot.step(dt);
    EXPECT_NEAR(robot.pose().x, 0.1 + 0.6 * way, 1e-12) << dt;
    EXPECT_NEAR(robot.pose().y, 0.2 - 0.8 * way, 1e-12) << dt;
    EXPECT_EQ(robot.pose().theta, 1.0);
  }
}

TEST(SimulatedRobot, AHandStopsASlide) {
  SimulatedRobot robot({}, MotorModel::ideal, {}, 1, 0);
  robot.kick(0.5, 0.0);
  robot.place({0.1, 0.2, 0.0});
  robot.step(dt);
  EXPECT_EQ(robot.pose(), (Pose{0.1, 0.2, 0.0}));
}

TEST(SimulatedRobot, HearsOfCommandsAsLateAsItIsTold) {
  const auto way_after = [](double delay, int steps) {
    core::SimulatedRobot robot(DifferentialDrive{}, core::MotorModel::ideal, {}, 1, 0);
    robot.place({});
    if (delay > 0.0) robot.delay_commands(delay);
    robot.command({100.0, 100.0});
    for (int k = 0; k < steps; ++k) {
      if (k == 5) robot.command({200.0, 200.0});
      robot.step(0.04);
    }
    return robot.pose().x / DifferentialDrive{}.metres_per_step();
  };
  EXPECT_NEAR(way_after(0.0, 10), 100.0 * 0.2 + 200.0 * 0.2, 1e-9);
  EXPECT_NEAR(way_after(0.05, 10), 100.0 * 0.2 + 200.0 * 0.15, 1e-9);
  EXPECT_NEAR(way_after(0.09, 2), 0.0, 1e-12);
  EXPECT_NEAR(way_after(0.09, 3), 100.0 * 0.03, 1e-9);
}

}  // namespace
}  // namespace skein::test
