// The filter of poses: as good as its measurements at worst, honest about how good, and not fooled by a hand.
#include "core/estimation/pose_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/simulation/simulated_robot.h"
#include "draw.h"
#include "lab.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::FilterParameters;
using core::Imperfection;
using core::Measurement;
using core::Pose;
using core::PoseFilter;
using core::SimulatedRobot;

/// A robot that drives about at random, its filter, and how both do.
struct Drive {
  Drive(Draw& d, const Imperfection& imperfection)
      : draw(d), robot({}, core::MotorModel::ideal, imperfection, static_cast<std::uint64_t>(d.whole(1, 1 << 30)), 0) {
    robot.place(draw.pose(0.5));
  }
  /// One tick: measure, estimate, command, drive. The pose that the tick would use.
  Pose tick() {
    measured = robot.measure(now);
    const bool seen = measured.ever_seen();
    if (seen) expected = filter.see(parameters, measured);
    if (seen) estimate = filter.predict(now);
    if (step++ % 25 == 0) wheels = {draw.between(200.0, 700.0), draw.between(200.0, 700.0)};
    robot.command(wheels);
    filter.command(now, robot.twist());
    truth = robot.pose();
    robot.step(dt);
    now += dt;
    return estimate;
  }
  Draw& draw;
  SimulatedRobot robot;
  PoseFilter filter;
  FilterParameters parameters;
  core::WheelSpeeds wheels;
  Measurement measured;
  std::optional<Pose> expected;
  Pose estimate, truth;
  double now = 0.0;
  int step = 0;
};

TEST(PoseFilter, BelievesAMeasurementWithoutUncertaintyBitForBit) {
  holds("estimate equals measurement", [] {
    Draw draw(any_seed());
    Imperfection imperfect;
    imperfect.slip = 0.05;
    Drive drive(draw, imperfect);
    for (int k = 0; k < 100; ++k) {
      drive.tick();
      RC_ASSERT(drive.estimate == drive.measured.pose);
      RC_ASSERT(!drive.expected);
    }
  });
}

TEST(PoseFilter, HalvesTheNoise) {
  Draw draw(1);
  Imperfection imperfect;
  imperfect.pose_noise = 0.001, imperfect.heading_noise = 0.5 * core::pi / 180.0, imperfect.slip = 0.03;
  Drive drive(draw, imperfect);
  double measured = 0.0, filtered = 0.0;
  for (int k = 0; k < 5000; ++k) {
    drive.tick();
    measured += std::pow(core::distance(drive.measured.pose, drive.truth), 2);
    filtered += std::pow(core::distance(drive.estimate, drive.truth), 2);
  }
  EXPECT_LT(std::sqrt(filtered / measured), 0.65);
}

TEST(PoseFilter, LearnsTheHeadingFromWhereTheRobotCameOut) {
  // A heading that is hardly known, 0.2 m straight ahead, and a place that is known well: left of what was expected
  // means that the robot had been turned to the left.
  for (const double heading : {0.0, 1.0, 2.5, -2.0}) {
    PoseFilter filter;
    const FilterParameters exact_wheels{.slip = 0.0};
    filter.see(exact_wheels, {.pose = {0.1, 0.2, heading}, .captured_at = 0.0, .sigma_xy = 1e-4, .sigma_theta = 0.1});
    filter.command(0.0, {0.1, 0.0});
    const double true_heading = heading + 0.05, far = 0.2;
    filter.see(exact_wheels, {.pose = {0.1 + far * std::cos(true_heading), 0.2 + far * std::sin(true_heading), heading},
                              .captured_at = 2.0,
                              .sigma_xy = 1e-4,
                              .sigma_theta = 10.0});
    EXPECT_NEAR(core::wrap_angle(filter.predict(2.0).theta - heading), 0.05, 0.01) << heading;
  }
}

TEST(PoseFilter, AFrameThatComesLateChangesNothing) {
  PoseFilter filter;
  const Measurement newest{.pose = {0.1, 0.2, 0.3}, .captured_at = 1.0, .sigma_xy = 1e-3, .sigma_theta = 1e-2};
  filter.see({}, newest);
  const Eigen::Matrix3d covariance = filter.covariance();
  for (const double earlier : {1.0, 0.96, 0.0}) {
    Measurement older = newest;
    older.captured_at = earlier, older.pose = {0.5, 0.2, 0.3};
    EXPECT_FALSE(filter.see({}, older)) << earlier;
    EXPECT_EQ(filter.predict(1.0), newest.pose) << earlier;
    EXPECT_EQ(filter.covariance(), covariance) << earlier;
  }
}

TEST(PoseFilter, FusesTwoCamerasByTheirCovariances) {
  PoseFilter filter;
  const Measurement coarse{.pose = {0.10, 0.2, 0.3}, .captured_at = 1.0, .sigma_xy = 2e-3, .sigma_theta = 1e-2};
  const Measurement fine{.pose = {0.11, 0.2, 0.3}, .captured_at = 1.0, .sigma_xy = 1e-3, .sigma_theta = 1e-2};
  filter.see({}, coarse);
  EXPECT_FALSE(filter.fuse({}, fine));
  EXPECT_NEAR(filter.predict(1.0).x, (0.10 / 4.0 + 0.11) / (1.0 / 4.0 + 1.0), 1e-12) << "weights 1 / sigma^2";
  EXPECT_NEAR(filter.sigma_xy(), 1e-3 / std::sqrt(1.25), 1e-12);
}

/// Two cameras see a robot at other times, and the one's frames come after the other's newer ones.
TEST(PoseFilter, TakesALateMeasurementWhereTheCommandsHaveLedItSince) {
  const core::Twist forward{0.1, 0.5};
  const auto truth = [&](double time) { return core::advance({0.1, 0.2, 0.3}, forward, time); };
  const auto seen = [&](double time) { return Measurement{truth(time), time, 1e-3, 1e-2, core::How::tracked}; };
  PoseFilter filter, naive;
  for (PoseFilter* each : {&filter, &naive}) {
    each->command(0.0, forward);
    each->see({}, seen(0.04));
    each->see({}, seen(0.08));
  }
  EXPECT_FALSE(filter.surprise({}, seen(0.05)));
  EXPECT_FALSE(filter.fuse({}, seen(0.05)));
  EXPECT_LT(core::distance(filter.predict(0.08), truth(0.08)), 1e-9);
  EXPECT_LT(filter.sigma_xy(), naive.sigma_xy()) << "it has told something";
  // The control: as if it had been captured now, it is 3 mm behind.
  Measurement mistaken = seen(0.05);
  mistaken.captured_at = 0.08;
  naive.fuse({}, mistaken);
  EXPECT_GT(core::distance(naive.predict(0.08), truth(0.08)), 1e-3);
}

TEST(PoseFilter, NamesASurpriseAndChangesNothing) {
  PoseFilter filter;
  const Measurement seen{.pose = {0.1, 0.2, 0.3}, .captured_at = 1.0, .sigma_xy = 1e-3, .sigma_theta = 1e-2};
  EXPECT_FALSE(filter.surprise({}, seen)) << "nothing was expected";
  filter.see({}, seen);
  for (const double at : {0.98, 1.0, 1.04}) {
    Measurement jumped = seen;
    jumped.captured_at = at, jumped.pose.x += 0.05;
    const auto expected = filter.surprise({}, jumped);
    ASSERT_TRUE(expected) << at;
    EXPECT_EQ(*expected, seen.pose);
    EXPECT_EQ(filter.predict(1.0), seen.pose);
  }
  filter.displaced(1.04);
  Measurement announced = seen;
  announced.captured_at = 1.04, announced.pose.x += 0.05;
  EXPECT_FALSE(filter.surprise({}, announced)) << "a hand is known to have moved it";
}

TEST(PoseFilter, DoubtsAPoseMoreTheLongerItIsNotSeenThoughTheRobotStands) {
  const Measurement seen{.pose = {}, .captured_at = 0.0, .sigma_xy = 1e-3, .sigma_theta = 1e-2};
  for (const double seconds : {0.5, 8.0}) {
    PoseFilter filter;
    filter.see({}, seen);
    Measurement vague = seen;  // so vague that it says nothing, but of the time
    vague.captured_at = seconds, vague.sigma_xy = 1e3, vague.sigma_theta = 1e3;
    filter.see({}, vague);
    EXPECT_NEAR(filter.sigma_xy(), std::sqrt(1e-6 + 0.002 * 0.002 * seconds), 1e-6) << seconds;
    EXPECT_NEAR(filter.sigma_theta(), std::sqrt(1e-4 + 0.02 * 0.02 * seconds), 1e-6) << seconds;
  }
}

/// Its standard deviations are neither boast nor excuse: the error's mean square, measured in them, is about 1.
TEST(PoseFilter, KnowsTheWayOfARobotThatIsNotSeenHoweverManyCommandsItWasGiven) {
  holds("the pose after any number of commands without a sight, and after the robot has stopped, is the true one", [] {
    Draw draw(any_seed());
    SimulatedRobot robot({}, core::MotorModel::ideal, {}, 1, 0);
    robot.place(draw.pose(0.5));
    PoseFilter filter;
    const double dt = draw.between(0.001, 0.04);
    double now = draw.between(0.0, 1e3);
    const auto drive = [&](const core::WheelSpeeds& wheels) {
      robot.command(wheels);
      filter.command(now, robot.twist());
      robot.step(dt);
      now += dt;
    };
    for (int k = draw.whole(0, 300); k > 0; --k) drive({draw.between(-500.0, 500.0), draw.between(-500.0, 500.0)});
    (void)filter.see({}, {robot.pose(), now});
    double way = 0.0;
    for (int k = draw.whole(0, 900); k > 0; --k) {
      drive({draw.between(-500.0, 500.0), draw.between(-500.0, 500.0)});
      way += std::abs(robot.twist().v) * dt;
    }
    for (int k = draw.whole(0, 900); k > 0; --k) drive({});
    RC_ASSERT(core::distance(filter.predict(now), robot.pose()) <= 1e-7);
    RC_ASSERT(std::abs(filter.way_to(now).driven - way) <= 1e-9);
    // The next sight, which is late, surprises nobody.
    Measurement next{robot.pose(), now};
    for (int k = draw.whole(0, 200); k > 0; --k) drive({draw.between(-500.0, 500.0), draw.between(-500.0, 500.0)});
    RC_ASSERT(!filter.surprise({}, next));
    RC_ASSERT(!filter.see({}, next));
    RC_ASSERT(core::distance(filter.predict(now), robot.pose()) <= 1e-7);
  });
}

TEST(PoseFilter, KnowsHowGoodItIs) {
  for (const double latency : {0.0, 0.08}) {
    Draw draw(2);
    Imperfection imperfect;
    imperfect.pose_noise = 0.002, imperfect.heading_noise = 0.02, imperfect.slip = 0.1;
    imperfect.latency = latency;
    Drive drive(draw, imperfect);
    drive.parameters.slip = 0.1;
    double position = 0.0, heading = 0.0;
    int samples = 0;
    std::vector<Pose> truths;
    for (int k = 0; k < 5000; ++k) {
      drive.tick();
      truths.push_back(drive.truth);
      const auto then = static_cast<std::size_t>(std::lround(drive.measured.captured_at / dt));
      if (k < 50 || drive.measured.captured_at < 0.0) continue;
      const Pose at_capture = drive.filter.predict(drive.measured.captured_at);
      position += std::pow(core::distance(at_capture, truths[then]) / drive.filter.sigma_xy(), 2);
      heading += std::pow(core::wrap_angle(at_capture.theta - truths[then].theta) / drive.filter.sigma_theta(), 2);
      ++samples;
    }
    EXPECT_GT(position / samples, 0.3) << latency;
    EXPECT_LT(position / samples, 2.0) << latency;  // two directions
    EXPECT_GT(heading / samples, 0.3) << latency;
    EXPECT_LT(heading / samples, 1.2) << latency;
  }
}

TEST(PoseFilter, RecognisesAHandAndBeginsAnew) {
  holds("a jump of 5 cm or 90 degrees is told once, with the pose that was expected", [] {
    Draw draw(any_seed());
    Imperfection imperfect;
    imperfect.pose_noise = 0.001, imperfect.heading_noise = 0.01;
    imperfect.latency = draw.whole(0, 1) * 0.08;
    Drive drive(draw, imperfect);
    for (int k = 0; k < 50; ++k) drive.tick();
    const Pose from = drive.robot.pose();
    const bool turned = draw.whole(0, 1) == 1;
    const double angle = draw.between(-core::pi, core::pi);
    drive.robot.place(turned ? Pose{from.x, from.y, core::wrap_angle(from.theta + 0.5 * core::pi)}
                             : Pose{from.x + 0.05 * std::cos(angle), from.y + 0.05 * std::sin(angle), from.theta});
    int told = 0;
    for (int k = 0; k < 25; ++k) {
      drive.tick();
      if (!drive.expected) continue;
      ++told;
      RC_ASSERT(core::distance(*drive.expected, from) < 0.02);
      RC_ASSERT(drive.filter.predict(drive.measured.captured_at) == drive.measured.pose);
    }
    RC_ASSERT(told == 1);
  });
}

TEST(PoseFilter, AnnouncedJumpsAreNoSurprise) {
  Draw draw(3);
  Drive drive(draw, {});
  for (int k = 0; k < 50; ++k) drive.tick();
  drive.robot.place({0.9, 0.9, 1.0});
  drive.filter.displaced(drive.now);
  drive.tick();
  EXPECT_FALSE(drive.expected);
  EXPECT_EQ(drive.estimate, (Pose{0.9, 0.9, 1.0}));
  drive.robot.place({0.0, 0.0, 1.0});  // a second one, unannounced
  drive.tick();
  EXPECT_TRUE(drive.expected);
}

TEST(PoseFilter, ARobotThatIsHeldOrMissedForAWhileIsNotKidnapped) {
  holds("no false alarm with noise, slip, dropouts and a robot that stands while its wheels turn", [] {
    Draw draw(any_seed());
    Imperfection imperfect;
    imperfect.pose_noise = 0.002, imperfect.heading_noise = 0.02;
    imperfect.slip = 0.05, imperfect.dropout = 0.5, imperfect.latency = 0.08;
    Drive drive(draw, imperfect);
    const int held_from = draw.whole(20, 100);
    for (int k = 0; k < 200; ++k) {
      const Pose before = drive.robot.pose();
      drive.tick();
      RC_ASSERT(!drive.expected);
      if (k >= held_from && k < held_from + 50) drive.robot.place(before);  // against a wall
    }
  });
}

}  // namespace
}  // namespace skein::test
