// The tick on its own: what it does with lost robots, STOP, pauses, gains, limits and late deadlines.
#include "app/tick/control_tick.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "core/kinematics/step_motor.h"
#include "core/simulation/simulated_robot.h"
#include "tests/app/simulated_robots.h"

namespace skein::app {
namespace {

/// Four ideal robots around a tick, on a clock that the test owns.
class Bench {
 public:
  explicit Bench(const Experiment& e = paper_experiment())
      : experiment(e),
        tick(e),
        robots(test::robots_at_their_references(e)),
        measured(e.robots.size()),
        truth(e.robots.size()),
        blind(e.robots.size(), false) {}

  const TickRecord& step(std::vector<OperatorCommand> commands = {}, int elapsed = 1) {
    const double dt = elapsed * experiment.period();
    now += dt;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      robots[i].step(dt);
      truth[i] = robots[i].pose();
      if (!blind[i]) measured[i] = robots[i].measure(now);
    }
    TickInput input;
    input.now = now;
    input.elapsed = elapsed;
    input.stop = stop;
    input.measurements = measured;
    input.truth = truth;
    input.commands = commands;
    input.links = links;
    const TickRecord& record = tick.step(input);
    for (std::size_t i = 0; i < robots.size(); ++i) robots[i].command(record.robots[i].wheels);
    return record;
  }
  const TickRecord& start() { return step({commands::Start{}}); }
  const TickRecord& steps(int count) {
    for (int k = 1; k < count; ++k) step();
    return step();
  }

  Experiment experiment;
  ControlTick tick;
  std::vector<core::SimulatedRobot> robots;
  std::vector<core::Measurement> measured;
  std::vector<core::Pose> truth;
  std::vector<bool> blind;
  std::vector<LinkInput> links;  // none: simulated robots
  double now = 0.0;
  bool stop = false;
};

template <typename Kind>
bool happened(const TickRecord& record) {
  return record.events.contains<Kind>();
}
template <typename Kind>
bool happened(const TickRecord& record, std::size_t robot) {
  return record.events.contains<Kind>(robot);
}

bool stands(const RobotRecord& robot) {
  return robot.command == core::Twist{} && robot.wheels == core::WheelSpeeds{} && robot.is(stopped);
}

TEST(ControlTick, RobotsStandUntilTheStart) {
  Bench bench;
  for (int k = 0; k < 10; ++k) {
    const TickRecord& record = bench.step();
    EXPECT_EQ(record.phase, Phase::ready);
    EXPECT_EQ(record.tick, 0);
    for (const RobotRecord& robot : record.robots) EXPECT_TRUE(stands(robot));
  }
  const TickRecord& first = bench.start();
  EXPECT_EQ(first.phase, Phase::running);
  EXPECT_EQ(first.tick, 0);
  EXPECT_TRUE(happened<events::Start>(first));
  EXPECT_GT(first.robots[0].command.v, 0.0);
  EXPECT_EQ(bench.step().tick, 1);
}

TEST(ControlTick, TimeIsTheTicksAndEndsWithTheDuration) {
  Bench bench;
  bench.start();
  const TickRecord& record = bench.steps(2099);
  EXPECT_EQ(record.tick, 2099);
  EXPECT_EQ(record.t, 2099 / 25.0);
  EXPECT_EQ(record.phase, Phase::running);
  EXPECT_EQ(bench.step().phase, Phase::finished);
  for (const RobotRecord& robot : bench.step().robots) EXPECT_TRUE(stands(robot));
}

TEST(ControlTick, ARobotCarriedElsewhereIsAPerturbation) {
  Bench bench;
  bench.start();
  bench.steps(50);
  const core::Pose before = bench.robots[1].pose();
  bench.robots[1].place({before.x + 0.1, before.y - 0.2, before.theta});
  const TickRecord& record = bench.step();
  ASSERT_TRUE(happened<events::Kidnap>(record, 1));
  const auto& kidnap = std::get<events::Kidnap>(*record.events.begin());
  EXPECT_NEAR(kidnap.dx, 0.1, 1e-3);
  EXPECT_NEAR(kidnap.dy, -0.2, 1e-3);
  for (int k = 0; k < 100; ++k) ASSERT_FALSE(happened<events::Kidnap>(bench.step(), 1));  // once
}

TEST(ControlTick, FollowsThePlatoonWithoutError) {
  Bench bench;
  bench.start();
  for (int k = 0; k < 500; ++k) {
    const TickRecord& record = bench.step();
    ASSERT_LT(record.tracking_error(), 2e-3);
    ASSERT_LT(record.formation_error(), 2e-3);
    for (const RobotRecord& robot : record.robots) {
      ASSERT_EQ(robot.mode, tracking);
      ASSERT_EQ(robot.reference, robot.nominal);
      ASSERT_GT(robot.margins.a, 0.0);
    }
  }
}

TEST(ControlTick, StopIsLatched) {
  Bench bench;
  bench.start();
  bench.steps(50);
  bench.stop = true;
  const TickRecord& record = bench.step();
  EXPECT_EQ(record.phase, Phase::stopped);
  EXPECT_TRUE(happened<events::Stop>(record));
  for (const RobotRecord& robot : record.robots) EXPECT_TRUE(stands(robot));

  bench.stop = false;  // whatever is asked afterwards, nobody moves
  const TickRecord& after = bench.step({commands::Start{}, commands::Resume{}});
  EXPECT_EQ(after.phase, Phase::stopped);
  for (const RobotRecord& robot : after.robots) EXPECT_TRUE(stands(robot));
}

TEST(ControlTick, StopBeforeTheStartKeepsTheStartFromHappening) {
  Bench bench;
  bench.step();
  bench.stop = true;
  EXPECT_EQ(bench.start().phase, Phase::stopped);
}

TEST(ControlTick, APauseStopsRobotsAndTime) {
  Bench bench;
  bench.start();
  const double t = bench.steps(100).t;
  const TickRecord& paused = bench.step({commands::Pause{}});
  EXPECT_EQ(paused.phase, Phase::paused);
  const double t_paused = paused.t;
  EXPECT_NEAR(t_paused, t, 0.05);
  for (int k = 0; k < 50; ++k) {
    const TickRecord& record = bench.step();
    ASSERT_EQ(record.t, t_paused);
    for (const RobotRecord& robot : record.robots) ASSERT_TRUE(stands(robot));
  }
  bench.step({commands::Resume{}});
  const TickRecord& record = bench.steps(100);
  EXPECT_NEAR(record.t, t_paused + 4.0, 0.05);
  EXPECT_LT(record.tracking_error(), 2e-3);
}

TEST(ControlTick, ALostRobotStopsAndLeavesTheGroup) {
  Bench bench;
  bench.start();
  bench.steps(50);
  bench.robots[1].place(
      {bench.truth[1].x, bench.truth[1].y + 0.05, bench.truth[1].theta});  // so that couplings do something
  bench.steps(2);
  EXPECT_GT(std::abs(bench.tick.record().robots[0].error.x), 1e-6) << "its neighbour feels it";

  bench.blind[1] = true;
  int ticks_until_lost = 0;
  while (!bench.step().robots[1].is(lost)) ASSERT_LT(++ticks_until_lost, 20);
  const TickRecord& record = bench.tick.record();
  EXPECT_TRUE(happened<events::Lost>(record, 1));
  EXPECT_GT(record.robots[1].pose_age, bench.experiment.estimation.bridge);
  EXPECT_LE(record.robots[1].pose_age, bench.experiment.estimation.bridge + bench.experiment.period() + 1e-9)
      << "within one tick of the bridge time";
  EXPECT_TRUE(stands(record.robots[1]));
  EXPECT_TRUE(std::isnan(record.robots[1].error.x));

  // Nobody is coupled to a guess: the others come home as if it were not there.
  const TickRecord& later = bench.steps(500);
  for (const std::size_t i : {0u, 2u, 3u})
    EXPECT_LT(std::hypot(later.robots[i].error.x, later.robots[i].error.y), 2e-3);

  bench.blind[1] = false;
  const TickRecord& found = bench.step();
  EXPECT_TRUE(happened<events::Found>(found, 1));
  EXPECT_FALSE(found.robots[1].is(lost));
}

TEST(ControlTick, ARobotThatWasNeverSeenStands) {
  Bench bench;
  bench.blind[2] = true;
  bench.start();
  for (int k = 0; k < 20; ++k) EXPECT_TRUE(stands(bench.step().robots[2]));
  EXPECT_FALSE(stands(bench.tick.record().robots[0]));
}

TEST(ControlTick, GainsMoveAtABoundedRateAndAreHeldAtTheLimit) {
  Bench bench;
  bench.start();
  bench.steps(10);
  const TickRecord& asked = bench.step({commands::SetGain{core::GainName::k_xx, 1.0}});
  EXPECT_TRUE(happened<events::Gain>(asked));
  EXPECT_TRUE(happened<events::GainHeld>(asked));
  double before = asked.k_xx;
  for (int k = 0; k < 500; ++k) {
    const TickRecord& record = bench.step();
    ASSERT_LE(std::abs(record.k_xx - before), 0.1 / 3 / 5 * 0.04 + 1e-12) << "never a jump";
    for (const RobotRecord& robot : record.robots) ASSERT_GT(robot.margins.a, 0.0) << "(18a) holds throughout";
    before = record.k_xx;
  }
  // (18f) with 5 % of v_max left to tracking: (0.095 - 0.05) / 3.
  EXPECT_NEAR(before, 0.015, 1e-9);
}

TEST(ControlTick, AGainSetBeforeTheStartHoldsFromTheFirstTick) {
  Bench bench;
  bench.step({commands::SetGain{core::GainName::k_yy, 0.05}});
  EXPECT_EQ(bench.start().k_yy, 0.05);
}

TEST(ControlTick, FileGainChangesAreRamped) {
  Experiment experiment = paper_experiment();
  GainChange change;
  change.t = 1.0;
  change.ramp = 2.0;
  change[core::GainName::k_tt] = core::PairTable(4, 0.065);
  experiment.gain_changes = {change};
  Bench bench(experiment);
  bench.start();
  EXPECT_EQ(bench.steps(24).k_tt, 0.025);
  bench.steps(26);  // t = 2 s, half way
  EXPECT_NEAR(bench.tick.record().k_tt, 0.045, 0.001);
  EXPECT_NEAR(bench.steps(30).k_tt, 0.065, 1e-12);
}

TEST(ControlTick, LimitsBiteVisiblyAndAreObeyed) {
  Bench bench;
  bench.start();
  bench.steps(20);
  // The witness of the reading notes: x_e of one robot nearly 0, of the other a metre. The coupling as printed asks for
  // far too much.
  const core::Pose there = bench.truth[3];
  bench.robots[3].place({there.x + std::cos(there.theta), there.y + std::sin(there.theta), there.theta});
  bool bitten = false;
  for (int k = 0; k < 200; ++k) {
    const TickRecord& record = bench.step();
    for (std::size_t i = 0; i < 4; ++i) {
      const RobotRecord& robot = record.robots[i];
      bitten = bitten || (robot.is(limited) && std::abs(robot.law.v) > 0.2);
      ASSERT_LE(std::abs(robot.command.v), 0.1 + 1e-12);
      ASSERT_LE(std::abs(robot.command.omega), 1.7 + 1e-12);
      ASSERT_LE(std::abs(robot.wheels.left), 1000.0 + 1e-9);
      ASSERT_LE(std::abs(robot.wheels.right), 1000.0 + 1e-9);
    }
  }
  EXPECT_TRUE(bitten);
}

TEST(ControlTick, ARobotWhoseCommandsAreUnconfirmedIsSlowedAndThenStands) {
  Bench bench;
  bench.links.assign(4, {.linked = true, .blind_way = 0.0});
  bench.start();
  bench.steps(20);
  const double budget = bench.experiment.links.blind_distance;
  for (const auto& [share, trusted] :
       {std::pair(0.25, 1.0), std::pair(0.5, 1.0), std::pair(0.75, 0.5), std::pair(1.0, 0.0)}) {
    bench.links[2].blind_way = share * budget;
    const RobotRecord& robot = bench.step().robots[2];
    EXPECT_EQ(robot.is(late), trusted < 1.0) << share;
    if (trusted > 0.0) {
      EXPECT_NEAR(robot.command.v, trusted * robot.law.v, 1e-12) << share;
      EXPECT_NEAR(robot.command.omega, trusted * robot.law.omega, 1e-12) << share;
      EXPECT_GT(robot.law.v, 0.03);
    } else {
      EXPECT_TRUE(stands(robot));
    }
  }
}

/// Whoever is behind catches up no faster than its blind distance lasts for a reply that is late. The control: without
/// links, the same robot turns and drives as (14) allows.
TEST(ControlTick, ARobotWithALinkCatchesUpNoFasterThanItsBlindDistanceLasts) {
  for (const bool linked : {false, true}) {
    Experiment experiment = paper_experiment();
    experiment.links.blind_distance = 0.03;
    const double lasts = experiment.links.blind_distance / experiment.links.reply_timeout;
    Bench bench(experiment);
    if (linked) bench.links.assign(4, {.linked = true, .blind_way = 0.0});
    const core::Pose start = bench.robots[2].pose();
    bench.robots[2].place({start.x, start.y, core::wrap_angle(start.theta + 2.0)});
    bench.start();
    const auto faster_wheel = [&](const core::Twist& twist) {
      return std::abs(twist.v) + 0.5 * experiment.robots[2].drive.track * std::abs(twist.omega);
    };
    int too_fast = 0, slowed = 0;
    for (int k = 0; k < 400; ++k) {
      const RobotRecord& robot = bench.step().robots[2];
      too_fast += faster_wheel(robot.command) > std::max(lasts, faster_wheel(robot.nominal.twist)) + 1e-9 ? 1 : 0;
      slowed += (robot.limits & limit_link) != 0 ? 1 : 0;
    }
    EXPECT_EQ(too_fast > 0, !linked);
    EXPECT_EQ(slowed > 0, linked);
  }
}

TEST(ControlTick, CoarseMotorsKeepTheirMeanSpeed) {
  for (const core::MotorModel motor : {core::MotorModel::epuck1, core::MotorModel::epuck2}) {
    Experiment experiment = paper_experiment();
    for (RobotSpec& robot : experiment.robots) {
      robot.motor = motor;
      robot.drive.max_step_rate = core::max_step_rate(motor);
    }
    Bench bench(experiment);
    core::StepMotor wheel(motor);  // whose timer counts since some other time than the tick's idea of it
    wheel.advance(0.003);
    bench.start();
    double wanted = 0.0, worst = 0.0;
    core::WheelSpeeds told;
    for (int k = 0; k < 400; ++k) {
      const RobotRecord& robot = bench.step().robots[0];
      ASSERT_EQ(robot.wheels.left, std::round(robot.wheels.left)) << "whole steps";
      // The right wheel's new speed costs the left one steps as well; an unchanged command is not sent.
      if (robot.wheels != told) wheel.command(robot.wheels.left);
      told = robot.wheels;
      wheel.advance(experiment.period());
      wanted += experiment.robots[0].drive.wheels(robot.command).left * experiment.period();
      worst = std::max(worst, std::abs(wanted - wheel.position()));
    }
    EXPECT_LT(worst, 3.0) << "steps";
    EXPECT_LT(bench.tick.record().tracking_error(), 2e-3);
  }
}

// The shield lets the e-puck2 come slowly, which is in half steps: one within 10 ms of each command from standing.
TEST(ControlTick, AnEpuck2ThatTheShieldSlowsKeepsItsDistanceAtAnyRate) {
  for (const double rate : {25.0, 50.0, 100.0}) {
    auto experiment = parse_experiment(R"(
reference = { kind = "independent", speed = 0.09, may_meet = true }
controller.gains = { k_xx = 0.0, k_tt = 0.0, k_yy = 0.0 }
avoidance = { kind = "field", enabled = false }
shield.gamma = 24.0
[[robot]]
model = "epuck2"
start = [0.37, 0.32, -0.12]
trajectory = { path = { shape = "line", from = [0.37, 0.32], to = [-0.15, -0.13] } }
[[robot]]
model = "open"
start = [0.344, 0.19, 2.43]
trajectory = { path = { shape = "line", from = [0.344, 0.19], to = [0.307, 0.246] } }
)",
                                       "e.toml");
    ASSERT_TRUE(experiment) << experiment.error().front().message();
    experiment->rate = rate;
    Bench bench(*experiment);
    bench.start();
    double least = 1.0;
    for (int k = 0; k < 25.0 * rate; ++k) {
      const RobotRecord& robot = bench.step().robots[0];
      least = std::min(least, core::distance(bench.truth[0], bench.truth[1]));
      const core::WheelSpeeds wanted = experiment->robots[0].drive.wheels(robot.command);
      ASSERT_GE(robot.wheels.left * wanted.left, 0.0) << "a wheel that has rolled too far waits; t = " << bench.now;
      ASSERT_GE(robot.wheels.right * wanted.right, 0.0) << "t = " << bench.now;
    }
    const double bodies = experiment->robots[0].radius + experiment->robots[1].radius;
    EXPECT_GT(least, bodies + 0.007) << rate << " Hz";
  }
}

TEST(ControlTick, MissedDeadlinesShowAndKeepTheClock) {
  Bench bench;
  bench.start();
  bench.steps(9);
  const TickRecord& late = bench.step({}, 4);
  EXPECT_EQ(late.tick, 13);
  EXPECT_NEAR(late.period, 4 * 0.04, 1e-12);
  ASSERT_TRUE(happened<events::DeadlineMissed>(late));
  EXPECT_EQ(std::get<events::DeadlineMissed>(*late.events.begin()).ticks, 3);
}

TEST(ControlTick, PosesAreCarriedToTheTimeOfTheCommand) {
  Experiment experiment = paper_experiment();
  experiment.simulation.latency = 0.08;
  Bench bench(experiment);
  bench.start();
  for (int k = 0; k < 600; ++k) {
    const TickRecord& record = bench.step();
    if (k < 5) continue;
    for (const RobotRecord& robot : record.robots) {
      ASSERT_NEAR(robot.pose_age, 0.08, 1e-9);
      ASSERT_LT(core::distance(robot.pose, robot.truth), 1e-9) << "the commands since the capture explain every move";
    }
  }
}

Experiment undisturbed(double duration) {
  Experiment e = paper_experiment();
  e.duration = duration;
  e.perturbations.clear();
  e.gain_changes.clear();
  return e;
}

TEST(ControlTick, ARobotTurnedByHandBesideTheEdgeStaysInside) {
  Experiment e = undisturbed(60.0);
  e.arena_width = 1.5, e.arena_height = 1.1;  // 0.1 m from the path to the edge
  double over = -1.0;
  for (int k = 0; k < 8; ++k) {
    Bench bench(e);
    bench.start();
    bench.steps(50 + 40 * k);
    core::Pose pose = bench.robots[0].pose();  // beside the nearest edge, while its place drives on behind it
    pose.x = std::copysign(0.75 - 0.045, pose.x);
    pose.theta = pose.x > 0.0 ? core::pi - 0.05 * k : 0.05 * k;
    bench.robots[0].place(pose);
    for (int step = 0; step < 750; ++step) {
      bench.step();
      for (const core::SimulatedRobot& r : bench.robots)
        over = std::max({over, std::abs(r.pose().x) - 0.75 + core::standard_radius,
                         std::abs(r.pose().y) - 0.55 + core::standard_radius});
    }
  }
  EXPECT_LE(over, 0.0);
}

TEST(ControlTick, SaysOnceThatARobotIsOverTheEdge) {
  Bench bench(undisturbed(60.0));
  bench.start();
  bench.robots[2].place({1.05, 0.0, 0.0});
  int said = 0;
  for (int k = 0; k < 25; ++k)
    for (const Event& event : bench.step().events)
      if (const auto* const e = std::get_if<events::Outside>(&event)) {
        EXPECT_EQ(++said, 1);
        EXPECT_EQ(e->robot, 2u);
        EXPECT_NEAR(e->over, 0.05 + core::standard_radius, 0.003);  // it drives on
      }
  EXPECT_EQ(said, 1);
}

TEST(ControlTick, SaysWhoMakesNoProgressForThreeSecondsAndWhy) {
  Bench bench(undisturbed(60.0));
  bench.start();
  bench.steps(25);
  bench.step({commands::Hold{1, true}});
  double held_at = bench.now, said_at = -1.0;
  for (int k = 0; k < 250; ++k)
    for (const Event& event : bench.step().events)
      if (const auto* const e = std::get_if<events::NoProgress>(&event); e && e->robot == 1) {
        EXPECT_EQ(e->hindrance, Hindrance::held);
        EXPECT_LT(said_at, 0.0);  // said once
        said_at = bench.now;
      }
  EXPECT_GT(said_at, held_at + 3.0 - 1e-9);
  EXPECT_LT(said_at, held_at + 4.0);  // it is at its place for the first moment
}

TEST(ControlTick, TheFirstSightOfARobotIsNoRiseOfV) {
  for (const double latency : {0.04, 0.08, 0.16}) {
    Experiment e = undisturbed(20.0);
    e.simulation.latency = latency;
    Bench bench(e);
    for (core::SimulatedRobot& r : bench.robots) r.place({r.pose().x + 0.03, r.pose().y - 0.03, r.pose().theta + 0.2});
    bench.start();
    for (int k = 0; k < 250; ++k)
      for (const Event& event : bench.step().events)
        EXPECT_FALSE(is<events::VRise>(event)) << latency << " s, at " << bench.now << " s";
  }
}

}  // namespace
}  // namespace skein::app
