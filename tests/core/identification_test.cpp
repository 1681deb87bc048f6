// Identification: it finds what a simulated robot really is, its intervals are neither too narrow nor too wide, and it
// says what the data cannot tell.
#include "core/estimation/identification.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/simulation/individual_robot.h"
#include "lab.h"

namespace skein::test {
namespace {

using core::Estimate;
using core::Identification;
using core::IdentificationInput;
using core::Individual;
using core::IndividualRobot;
using core::MotorModel;
using core::Random;
using core::truth_of;
using core::Twist;
using core::Unknown;

/// What is on record of a robot that was told to drive so, by somebody who believes that it is as the drawing says.
template <typename Told>
IdentificationInput driven(const Individual& individual, std::uint64_t seed, double seconds, Told&& told) {
  IdentificationInput input;
  IndividualRobot robot(individual, MotorModel::epuck2, seed);
  core::WheelLog log(MotorModel::epuck2);
  for (int k = 0; k * dt < seconds; ++k) {
    if (const auto seen = robot.see()) input.poses.push_back({seen->captured_at, seen->pose});
    const core::WheelSpeeds speeds = input.believed.wheels(told(k * dt));
    const core::WheelSpeeds whole{core::nearest_command(MotorModel::epuck2, speeds.left),
                                  core::nearest_command(MotorModel::epuck2, speeds.right)};
    robot.command(whole);
    log.command(k * dt, whole);
    robot.step(dt);
  }
  input.wheels = std::move(log).finish(seconds);
  return input;
}

Twist bends(double t) {
  return {0.05 + 0.03 * std::sin(0.9 * t), 1.2 * std::sin(0.57 * t) + 0.5 * std::sin(2.0 * t)};
}
Twist straight(double) {
  return {0.06, 0.0};
}

TEST(Identification, HoldsTheTruthInsideItsIntervals) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr int runs = 5;
#else
  constexpr int runs = 40;
#endif
  int held = 0;
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const Individual truth = core::random_individual(seed);
    const Identification found = core::identify(driven(truth, seed, 30.0, bends));
    ASSERT_TRUE(found.converged) << "seed " << seed;
    for (std::size_t i = 0; i < core::unknowns; ++i) {
      const auto unknown = static_cast<Unknown>(i);
      const Estimate& e = found[unknown];
      held += e.low <= truth_of(truth, unknown) && truth_of(truth, unknown) <= e.high;
      squares += std::pow((e.value - truth_of(truth, unknown)) / ((e.high - e.low) / 3.92), 2);
    }
    for (const Unknown unknown : {Unknown::left_diameter, Unknown::right_diameter, Unknown::track, Unknown::delay})
      EXPECT_TRUE(found[unknown].known) << word(unknown) << " of seed " << seed;
  }
  // Of 400 intervals 380 should hold, give or take 4.4; and errors be as large as the intervals say.
  const double all = runs * static_cast<double>(core::unknowns);
  EXPECT_GE(held / all, 0.9);
  EXPECT_LE(held / all, runs > 20 ? 0.99 : 1.0);
  EXPECT_NEAR(std::sqrt(squares / all), 1.0, 0.2);
}

/// A feedback that trembles changes the wheels' speeds at every tick, and a delay of about a whole number of ticks is
/// where poses meet these changes: there the delay's posterior is no single bell. And so short a run tells of the slip
/// as much as some dozens of draws would, so that a part of it is lost to the fit.
TEST(Identification, IntervalsHoldNearAWholeNumberOfTicksAndAfterAShortRun) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr int runs = 3;
#else
  constexpr int runs = 40;
#endif
  int held = 0;
  double slips = 0.0;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    Individual truth = core::random_individual(seed);
    truth.actuation_delay = dt + 0.003, truth.camera_delay = 0.0;
    Random tremble(seed, 5);
    const Identification found = core::identify(driven(truth, seed, 20.0, [&](double t) {
      const double v = 0.05 + 0.002 * tremble.gaussian();
      return Twist{v, 0.6 * std::sin(0.4 * t) + 0.05 * tremble.gaussian()};
    }));
    ASSERT_TRUE(found.converged) << "seed " << seed;
    const Estimate &delay = found[Unknown::delay], &slip = found[Unknown::slip];
    EXPECT_LE(delay.low, delay.value);
    EXPECT_GE(delay.high, delay.value);
    held += delay.low <= 0.043 && 0.043 <= delay.high;
    slips += std::log(slip.value / truth.slip) / (std::log(slip.high / slip.low) / 3.92);
  }
  if (runs < 40) return;
  EXPECT_GE(held, 34) << "of 40: 35, and 30 if Fisher's information is all that is asked";
  EXPECT_NEAR(slips / runs, 0.0, 0.3) << "standard deviations; -0.54 if the fit is not discounted";
}

/// Of a long run the search goes by a part of it first.
TEST(Identification, ALongRunTellsTheTruth) {
  const Individual truth = core::random_individual(3);
  const IdentificationInput input = driven(truth, 3, 1000.0, bends);
  ASSERT_GT(input.poses.size(), 21'000u);
  const Identification found = core::identify(input);
  ASSERT_TRUE(found.converged);
  for (const Unknown unknown : {Unknown::left_diameter, Unknown::right_diameter, Unknown::track, Unknown::delay}) {
    const Estimate& e = found[unknown];
    EXPECT_NEAR((e.value - truth_of(truth, unknown)) / ((e.high - e.low) / 3.92), 0.0, 3.5) << word(unknown);
    EXPECT_TRUE(e.known) << word(unknown);
  }
}

TEST(Identification, ALongRunWhoseRobotStoodAtFirstTellsTheTruthToo) {
  Individual truth = core::random_individual(4);
  truth.actuation_delay = 0.31, truth.camera_delay = 0.0;
  const IdentificationInput input = driven(truth, 4, 1000.0, [](double t) {
    return t < 940.0 ? Twist{0.0, 0.0} : bends(t);
  });
  const Identification found = core::identify(input);
  ASSERT_TRUE(found.converged);
  for (const Unknown unknown : {Unknown::left_diameter, Unknown::right_diameter, Unknown::track, Unknown::delay}) {
    const Estimate& e = found[unknown];
    EXPECT_NEAR((e.value - truth_of(truth, unknown)) / ((e.high - e.low) / 3.92), 0.0, 3.5) << word(unknown);
  }
}

TEST(Identification, IsExactWhereNothingIsNoisy) {
  Individual truth;
  truth.wheels = core::random_individual(3).wheels;
  truth.actuation_delay = 0.07;
  const Identification found = core::identify(driven(truth, 3, 30.0, bends));
  ASSERT_TRUE(found.converged);
  EXPECT_NEAR(found[Unknown::left_diameter].value / truth_of(truth, Unknown::left_diameter), 1.0, 1e-3);
  EXPECT_NEAR(found[Unknown::right_diameter].value / truth_of(truth, Unknown::right_diameter), 1.0, 1e-3);
  EXPECT_NEAR(found[Unknown::track].value / truth.wheels.track, 1.0, 1e-3);
  EXPECT_NEAR(found[Unknown::delay].value, 0.07, 1e-3);
  const core::DifferentialDrive drive = found.drive({});
  EXPECT_NEAR(drive.wheel_ratio, truth.wheels.wheel_ratio, 1e-3);
  EXPECT_NEAR(drive.left_diameter() / truth.wheels.left_diameter(), 1.0, 1e-3);
}

/// Without noise of the poses the cost is flat along its logarithm, which must not keep the others from their best.
TEST(Identification, NoiseThatIsNearlyNoneHoldsNoOtherValueBack) {
  Individual truth = core::random_individual(3);
  truth.pose_noise = truth.heading_noise = 0.0;
  const IdentificationInput input = driven(truth, 3, 1000.0, bends);
  const Identification found = core::identify(input);
  ASSERT_TRUE(found.converged);
  EXPECT_LE(found.iterations, 30);
  for (const Unknown unknown : {Unknown::left_diameter, Unknown::right_diameter, Unknown::track, Unknown::delay}) {
    const Estimate& e = found[unknown];
    EXPECT_NEAR((e.value - truth_of(truth, unknown)) / ((e.high - e.low) / 3.92), 0.0, 3.5) << word(unknown);
  }
}

TEST(Identification, SaysWhatTheDataCannotTell) {
  const Individual truth = core::random_individual(5);
  const Identification ahead = core::identify(driven(truth, 5, 20.0, straight));
  ASSERT_TRUE(ahead.converged);
  EXPECT_FALSE(ahead[Unknown::track].known) << "a straight says nothing of the track";
  EXPECT_LE(ahead[Unknown::track].low, truth.wheels.track);
  EXPECT_GE(ahead[Unknown::track].high, truth.wheels.track);
  EXPECT_FALSE(ahead[Unknown::tag_ahead].known);
  const Identification standing = core::identify(driven(truth, 5, 20.0, [](double) { return Twist{}; }));
  EXPECT_FALSE(standing.converged) << "it never moved";
  for (const Estimate& e : standing.estimates) EXPECT_FALSE(e.known);
  EXPECT_FALSE(core::identify({}).converged);
}

TEST(Identification, PassesOverOutliersAndHands) {
  const Individual truth = core::random_individual(7);
  IdentificationInput input = driven(truth, 7, 40.0, bends);
  const Identification clean = core::identify(input);
  input.poses[200].pose.x += 0.05;  // a wrong tag
  input.poses[500].pose.theta = core::wrap_angle(input.poses[500].pose.theta + 1.0);
  for (std::size_t k = 600; k < input.poses.size(); ++k) input.poses[k].pose.y += 0.3;  // a hand
  input.poses[600].anew = true;
  const Identification found = core::identify(input);
  ASSERT_TRUE(found.converged);
  std::vector<double> unused;
  for (const core::Innovation& innovation : found.innovations)
    if (!innovation.used) unused.push_back(innovation.t);
  EXPECT_EQ(unused, (std::vector{input.poses[200].t, input.poses[500].t}));
  for (const Unknown unknown : {Unknown::left_diameter, Unknown::right_diameter, Unknown::track, Unknown::delay}) {
    const Estimate &a = clean[unknown], &b = found[unknown];
    EXPECT_NEAR(a.value, b.value, 0.25 * (a.high - a.low)) << word(unknown);
  }
}

}  // namespace
}  // namespace skein::test
