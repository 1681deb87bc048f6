// The law is one part of the tick among others: whatever it asks for, what comes after it stays.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "app/experiment/experiment_file.h"
#include "core/controllers/controller_types.h"
#include "core/words.h"
#include "tests/app/fixture.h"
#include "tests/app/simulated_robots.h"

namespace skein::app {
namespace {

Experiment experiment_of(std::vector<std::string> sets) {
  const auto experiment = parse_experiment("", "e.toml", sets);
  EXPECT_TRUE(experiment) << experiment.error().front().message();
  return *experiment;
}

bool told(const TickRecord& row, const std::string& words) {
  for (const Event& event : row.events)
    if (describe(event) == words) return true;
  return false;
}

/// One running tick of a run with a controller of its own, robots at their places but `off` to the left, which answers
/// `law`.
class OwnLaw : public testing::Test {
 protected:
  void open(std::vector<std::string> sets = {}) {
    sets.emplace_back("controller.command=none");
    experiment_ = std::make_unique<Experiment>(experiment_of(sets));
    tick_ = std::make_unique<ControlTick>(*experiment_);
    reference_ = make_reference(*experiment_);
  }
  const TickRecord& step(const std::vector<core::Twist>& law, ControllerState state = ControllerState::answered) {
    const double now = static_cast<double>(k_) / experiment_->rate;
    std::vector<core::Measurement> measurements(4);
    for (std::size_t i = 0; i < 4; ++i) measurements[i] = {reference_->at(i, now).pose, now};
    const OperatorCommand start = commands::Start{};
    TickInput input;
    input.now = now;
    input.measurements = measurements;
    if (k_++ == 0) input.commands = {&start, 1};
    tick_->see(input);
    asked_ = tick_->ask() != nullptr;
    input.law = law;
    input.controller = state;
    return tick_->decide(input);
  }
  static constexpr core::Twist nothing{none, none};
  std::unique_ptr<Experiment> experiment_;
  std::unique_ptr<ControlTick> tick_;
  std::unique_ptr<const core::Reference> reference_;
  bool asked_ = false;
  int k_ = 0;
};

TEST_F(OwnLaw, IsDoneInsideTheLimitsAndStandsInTheRecordAsItWasAsked) {
  open();
  const TickRecord& row = step({{0.05, 0.1}, {5.0, 0.0}, {0.0, -80.0}, {-1e5, 1e5}});
  EXPECT_TRUE(asked_);
  EXPECT_EQ(row.robots[1].law, (core::Twist{5.0, 0.0}));
  EXPECT_EQ(row.robots[3].law, (core::Twist{-1e5, 1e5}));
  for (const RobotRecord& robot : row.robots) {
    EXPECT_LE(std::abs(robot.command.v), 0.1);
    EXPECT_LE(std::abs(robot.command.omega), 1.7);
  }
  EXPECT_TRUE(row.robots[1].is(limited));
  EXPECT_FALSE(row.robots[0].is(limited));
  EXPECT_TRUE(std::isnan(row.V_dot));
}

TEST_F(OwnLaw, MakesOnlyThatRobotStandOfWhichItAsksNoNumber) {
  open();
  const double infinity = std::numeric_limits<double>::infinity();
  const TickRecord& row = step({{0.05, 0.1}, {none, 0.1}, {0.05, -infinity}, {2e6, 0.0}});
  EXPECT_FALSE(row.robots[0].is(stopped));
  for (const std::size_t i : {1u, 2u, 3u}) {
    EXPECT_TRUE(row.robots[i].is(stopped)) << i;
    EXPECT_EQ(row.robots[i].command, core::Twist{});
    EXPECT_TRUE(std::isnan(row.robots[i].law.v));
    EXPECT_TRUE(told(row, "no_number r" + std::to_string(i + 1)));
  }
  const TickRecord& next = step({{0.05, 0.1}, {none, 0.1}, {0.05, 0.1}, {0.05, 0.1}});
  EXPECT_FALSE(told(next, "no_number r2")) << "once is enough";
  EXPECT_FALSE(next.robots[2].is(stopped));
}

TEST_F(OwnLaw, LateMakesEverybodyStandForATickAndIsSaidOnce) {
  open();
  step({4, {0.05, 0.1}});
  const TickRecord& late = step({4, nothing}, ControllerState::late);
  EXPECT_TRUE(told(late, "controller late"));
  EXPECT_FALSE(told(late, "no_number r1"));
  for (const RobotRecord& robot : late.robots) EXPECT_EQ(robot.command, core::Twist{});
  EXPECT_FALSE(told(step({4, nothing}, ControllerState::late), "controller late"));
  const TickRecord& back = step({4, {0.05, 0.1}});
  EXPECT_TRUE(told(back, "controller answered"));
  EXPECT_EQ(back.robots[0].command, (core::Twist{0.05, 0.1}));
  EXPECT_TRUE(told(step({4, nothing}, ControllerState::ended), "controller ended"));
}

TEST_F(OwnLaw, IsReplacedByTheBuiltInOneWhereTheFileSaysSo) {
  open({"controller.failure=built_in"});
  const TickRecord& row = step({{0.01, 0.0}, nothing, {none, 0.0}, nothing}, ControllerState::late);
  EXPECT_EQ(row.robots[0].law, (core::Twist{0.01, 0.0}));
  for (const std::size_t i : {1u, 2u, 3u}) {
    EXPECT_FALSE(row.robots[i].is(stopped));
    EXPECT_NEAR(row.robots[i].command.v, 0.05, 1e-3);
  }
}

TEST_F(OwnLaw, DrivesNeitherWhileTheRobotsStandNorToTheirStarts) {
  open();
  TickInput input;
  std::vector<core::Measurement> measurements(4);
  for (std::size_t i = 0; i < 4; ++i) {
    measurements[i] = {reference_->at(i, 0.0).pose, 0.0};
    measurements[i].pose.x += 0.1;
  }
  input.measurements = measurements;
  tick_->see(input);
  EXPECT_EQ(tick_->ask(), nullptr);
  tick_->decide(input);
  const OperatorCommand stage = commands::Stage{};
  const std::vector<core::Twist> law(4, {9.0, 9.0});
  for (int k = 1; k < 50; ++k) {
    input.now = 0.04 * k;
    for (core::Measurement& m : measurements) m.captured_at = input.now;
    input.commands = {&stage, k == 1 ? 1u : 0u};
    input.law = law;
    tick_->see(input);
    EXPECT_EQ(tick_->ask(), nullptr);
    const TickRecord& row = tick_->decide(input);
    EXPECT_EQ(row.phase, Phase::staging);
    EXPECT_NE(row.robots[0].law, law[0]);
  }
}

TEST_F(OwnLaw, TurningBesideAnObstacleIsShieldedForTheHeadingInTheMiddleOfTheTick) {
  for (const double turn : {-1.0, 1.0}) {
    open();
    const core::ShieldParameters shield;
    const double gap = 0.005, radius = 0.05, omega = 1.2 * turn, to_obstacle = core::pi / 3.0;
    const core::Pose stands = reference_->at(0, 0.0).pose;
    const double far = shield.distance - core::standard_radius + radius + gap;
    experiment_->obstacles = {{stands.x + far * std::cos(stands.theta + to_obstacle),
                               stands.y + far * std::sin(stands.theta + to_obstacle), radius}};
    tick_ = std::make_unique<ControlTick>(*experiment_);
    k_ = 0;
    const core::Twist& command = step({{0.1, omega}, {}, {}, {}}).robots[0].command;
    EXPECT_EQ(command.omega, omega);
    EXPECT_NEAR(command.v, shield.gamma * gap / std::cos(to_obstacle - 0.5 * omega * experiment_->period()), 1e-9);
  }
}

TEST_F(OwnLaw, AtEachOtherAtFullSpeedIsHeldByTheShield) {
  Experiment e = experiment_of({"controller.command=none"});
  std::vector<core::SimulatedRobot> robots = test::robots_at_their_references(e);
  ControlTick tick(e);
  const OperatorCommand start = commands::Start{};
  std::vector<core::Measurement> measured(4);
  double nearest = 1.0;
  int shielded_ticks = 0;
  for (int k = 0; k < 500; ++k) {
    TickInput input;
    input.now = 0.04 * k;
    for (std::size_t i = 0; i < 4; ++i) measured[i] = robots[i].measure(input.now);
    input.measurements = measured;
    if (k == 0) input.commands = {&start, 1};
    // The even ones backwards, the odd ones ahead: into each other.
    const std::vector<core::Twist> law{{-1.0, 0.0}, {1.0, 0.0}, {-1.0, 0.0}, {1.0, 0.0}};
    tick.see(input);
    (void)tick.ask();
    input.law = law;
    const TickRecord& row = tick.decide(input);
    nearest = std::fmin(nearest, row.min_distance);
    shielded_ticks += row.robots[0].is(shielded);
    for (std::size_t i = 0; i < 4; ++i) {
      robots[i].command(row.robots[i].wheels);
      robots[i].step(e.period());
    }
  }
  EXPECT_GT(nearest, 0.07);
  EXPECT_LT(nearest, 0.09);
  EXPECT_GT(shielded_ticks, 100);
}

TEST(Laws, OfEveryKindBringThePlatoonBackFromAKick) {
  for (const core::ControllerKind kind : core::all_of<core::ControllerKind>()) {
    const auto rows = test::simulate(experiment_of({"duration=84", "perturb=[{t=2.0, robot=2, dx=0.04, dy=0.03}]",
                                                    "controller.kind=" + std::string(core::word(kind))}));
    const auto error = [&](double t) {
      double far = 0.0;
      for (const RobotRecord& robot : rows[static_cast<std::size_t>(25.0 * t)].robots)
        far = std::fmax(far, core::distance(robot.truth, robot.nominal.pose));
      return far;
    };
    EXPECT_GT(error(2.04), 0.03) << core::word(kind);
    EXPECT_LT(error(83.0), 0.02) << core::word(kind);
    for (const TickRecord& row : rows) ASSERT_GT(row.min_distance, 0.07) << core::word(kind);
    EXPECT_EQ(std::isnan(rows.back().V_dot), kind != core::ControllerKind::kostic);
  }
}

TEST(Laws, LogWhatTheyName) {
  const auto rows = test::simulate(experiment_of({"duration=1", "controller.kind=leader_follower"}));
  ASSERT_EQ(rows.back().logged.size(), 8u);
  EXPECT_TRUE(std::isnan(rows.back().logged[0]));
  EXPECT_NEAR(rows.back().logged[2], 0.12 - 0.03, 0.01);
  EXPECT_TRUE(test::simulate(experiment_of({"duration=1"})).back().logged.empty());
}

}  // namespace
}  // namespace skein::app
