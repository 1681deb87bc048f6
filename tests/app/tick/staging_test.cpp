// Staging: from wherever they stand, robots drive to their starts without touching, wait for Start, and the record of
// it all can be replayed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/record/statistics.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "app/tick/control_tick.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/rows.h"

namespace skein::app {
namespace {

/// The platoon, its robots in disorder: two of them on each other's starts, one turned round, one far off.
const Sets disorder{"duration=10",
                    "perturb=[]",
                    "robot.1.start=[-0.3, -0.2, 2.0]",
                    "robot.2.start=[0.6, 0.3, -3.0]",
                    "robot.3.start=[0.1, 0.1, 0.0]",
                    "robot.4.start=[0.0, -0.6, 1.0]"};

using test::Rows;

TEST(Staging, RobotsInDisorderFindTheirStartsBeforeTheRun) {
  const Experiment e = good(paper_experiment().source, disorder);
  Rows rows;
  Statistics statistics(e);
  std::ostringstream csv;
  CsvWriter writer(csv, e);
  auto session = Session::open(e, Session::Clock::virtual_, {false, {&rows, &statistics, &writer}});
  ASSERT_TRUE(session) << session.error();
  EXPECT_EQ((*session)->run(), Phase::finished) << (*session)->failure().value_or("");

  EXPECT_TRUE(rows.has<events::Stage>());
  EXPECT_TRUE(rows.has<events::Staged>());
  double least = 1.0;
  const TickRecord* first = nullptr;
  for (const TickRecord& row : rows.rows) {
    least = std::min(least, row.min_distance);
    if (row.phase == Phase::running && !first) first = &row;
    if (row.phase != Phase::staging) continue;
    EXPECT_EQ(row.tick, 0);
    for (const RobotRecord& robot : row.robots) {
      EXPECT_TRUE(robot.is(staging));
      EXPECT_TRUE(robot.margins.hold(1e-9)) << "(18), also on the way to the start";
    }
  }
  EXPECT_GT(least, 0.07);
  ASSERT_NE(first, nullptr);
  for (const RobotRecord& robot : first->robots) {
    EXPECT_LT(core::distance(robot.truth, robot.nominal.pose), 0.012);
    EXPECT_LT(std::abs(core::wrap_angle(robot.truth.theta - robot.nominal.pose.theta)), 0.06);
  }
  EXPECT_EQ(statistics.summary().ticks, 250) << "what comes before the start is no part of the run";

  std::istringstream in(csv.str());
  const auto again = replay(in, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->different, 0) << again->first;
  EXPECT_GT(again->ticks, 250);
}

TEST(Staging, APauseHoldsTheRobotsOnTheirWayUntilItIsResumed) {
  const Experiment e = good(paper_experiment().source, disorder);
  Rows rows;
  std::ostringstream csv;
  CsvWriter writer(csv, e);
  auto session = Session::open(e, Session::Clock::virtual_, {false, {&rows, &writer}});
  ASSERT_TRUE(session) << session.error();
  const auto refused = [](const Session::Answer& answer) { return answer ? std::string("taken") : answer.error(); };
  EXPECT_EQ(refused((*session)->pause()), "no robot drives");
  std::vector<core::Pose> held;
  int turns = 0;
  EXPECT_EQ((*session)->run([&] {  // every 16 ticks
    switch (++turns) {
      case 3:
        EXPECT_EQ(rows.rows.back().phase, Phase::staging);
        EXPECT_THAT(refused((*session)->start()), ::testing::HasSubstr("the robots drive to their starts"));
        EXPECT_THAT(refused((*session)->stage()), ::testing::HasSubstr("drive to their starts already"));
        EXPECT_EQ(refused((*session)->resume()), "it is not paused");
        EXPECT_EQ(refused((*session)->pause()), "taken");
        break;
      case 4:
        EXPECT_TRUE(rows.rows.back().paused());
        EXPECT_EQ(rows.rows.back().phase, Phase::staging);
        for (const RobotRecord& robot : rows.rows.back().robots) {
          EXPECT_EQ(robot.wheels, core::WheelSpeeds{});
          held.push_back(robot.truth);
        }
        EXPECT_EQ(refused((*session)->pause()), "it is paused");
        EXPECT_EQ(refused((*session)->start()), "it is paused: resume it");
        EXPECT_EQ(refused((*session)->stage()), "it is paused: resume it");
        break;
      case 8:
        for (std::size_t i = 0; i < held.size(); ++i) EXPECT_EQ(rows.rows.back().robots[i].truth, held[i]);
        EXPECT_EQ(refused((*session)->resume()), "taken");
        break;
      case 9:
        EXPECT_FALSE(rows.rows.back().paused());
        EXPECT_NE(rows.rows.back().robots[0].wheels, core::WheelSpeeds{});
        break;
      default:
        break;
    }
    return true;
  }),
            Phase::finished)
      << (*session)->failure().value_or("");
  EXPECT_EQ(refused((*session)->start()), "the run is over");
  EXPECT_EQ(refused((*session)->pause()), "the run is over");
  EXPECT_EQ(rows.count<events::Pause>(), 1);
  EXPECT_EQ(rows.count<events::Resume>(), 1);
  EXPECT_EQ(rows.count<events::Staged>(), 1);

  std::istringstream in(csv.str());
  const auto again = replay(in, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->different, 0) << again->first;
}

TEST(Staging, StopEndsItWhereItIsPaused) {
  const Experiment e = good(paper_experiment().source, disorder);
  auto session = Session::open(e, Session::Clock::virtual_, {});
  int turns = 0;
  EXPECT_EQ((*session)->run([&] {
    if (++turns == 3) {
      EXPECT_TRUE((*session)->pause());
    }
    return turns < 6;
  }),
            Phase::stopped);
  EXPECT_FALSE((*session)->failure());
}

TEST(Staging, ThoseAtTheirStartsDoNotStage) {
  const Experiment e = good(paper_experiment().source, {"duration=1", "perturb=[]"});
  Rows rows;
  auto session = Session::open(e, Session::Clock::virtual_, {false, {&rows}});
  (*session)->run();
  EXPECT_FALSE(rows.has<events::Stage>());
  EXPECT_EQ(rows.rows.size(), 25U);
}

TEST(Staging, FailsWhereSomebodyCannotArrive) {
  Sets sets = disorder;
  sets.emplace_back("staging.timeout=2");
  auto session = Session::open(good(paper_experiment().source, sets), Session::Clock::virtual_, {});
  EXPECT_EQ((*session)->run(), Phase::stopped);
  EXPECT_THAT(
      (*session)->failure().value_or(""),
      ::testing::MatchesRegex("staging: robot [1-4] has not reached its start within 2 s: it is 0\\.[0-9]+ m away"));

  sets.emplace_back("operator=[{t=0, does=\"hold r2\"}]");
  session = Session::open(good(paper_experiment().source, sets), Session::Clock::virtual_, {});
  EXPECT_EQ((*session)->run(), Phase::stopped);
  EXPECT_THAT((*session)->failure().value_or(""),
              ::testing::HasSubstr("robot 2 has not reached its start within 2 s: it is held"));
}

TEST(Staging, ARobotThatIsHeldStaysWhereItIsWhenTheOthersDriveBack) {
  const Experiment e = good(paper_experiment().source,
                            {"duration=2", "perturb=[]", "staging.back=true", "operator=[{t=0.5, does=\"hold r1\"}]"});
  Rows rows;
  auto session = Session::open(e, Session::Clock::virtual_, {false, {&rows}});
  EXPECT_EQ((*session)->run(), Phase::finished) << (*session)->failure().value_or("");
  EXPECT_TRUE(rows.has<events::Staged>());
  EXPECT_GT(core::distance(rows.rows.back().robots[0].truth, make_reference(e)->at(0, 0.0).pose), 0.012);
  for (std::size_t i = 1; i < 4; ++i)
    EXPECT_LT(core::distance(rows.rows.back().robots[i].truth, make_reference(e)->at(i, 0.0).pose), 0.012);
}

TEST(Staging, AfterTheRunTheyMayDriveBack) {
  const Experiment e = good(paper_experiment().source, {"duration=2", "perturb=[]", "staging.back=true"});
  Rows rows;
  Statistics statistics(e);
  auto session = Session::open(e, Session::Clock::virtual_, {false, {&rows, &statistics}});
  EXPECT_EQ((*session)->run(), Phase::finished) << (*session)->failure().value_or("");
  EXPECT_EQ(std::count_if(rows.rows.begin(), rows.rows.end(),
                          [](const TickRecord& row) { return row.phase == Phase::running; }),
            50);
  EXPECT_TRUE(rows.has<events::Staged>());
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT(core::distance(rows.rows.back().robots[i].truth, make_reference(e)->at(i, 0.0).pose), 0.012);
  EXPECT_EQ(statistics.summary().ticks, 50);
  EXPECT_LT(statistics.summary().final_error, 0.002) << "the way back is none of the run";
}

/// Everybody at its start, and a tick that has just been told to stage.
struct AtTheStarts {
  Experiment e = good(paper_experiment().source, {"perturb=[]"});
  ControlTick tick{e};
  std::vector<core::Measurement> measured = std::vector<core::Measurement>(e.robots.size());
  double now = 0.0;

  AtTheStarts() {
    for (std::size_t i = 0; i < measured.size(); ++i) measured[i].pose = make_reference(e)->at(i, 0.0).pose;
  }
  /// A tick later. `unseen`: robots from the first on.
  Phase step(std::size_t unseen = 0) {
    const OperatorCommand stage = commands::Stage{};
    for (std::size_t i = unseen; i < measured.size(); ++i) measured[i].captured_at = now;
    TickInput input;
    input.now = now;
    input.measurements = measured;
    if (now == 0.0) input.commands = {&stage, 1};
    now += e.period();
    return tick.step(input).phase;
  }
};

TEST(Staging, IsOverWhenEverybodyHasStoodForHalfASecondOnEnd) {
  AtTheStarts robots;
  for (int k = 0; k < 60; ++k) {
    const double turned = k % 10 == 5 ? 0.06 : 0.0;  // more than staging is content with
    robots.measured[0].pose.theta += turned;
    EXPECT_EQ(robots.step(), Phase::staging) << k;
    robots.measured[0].pose.theta -= turned;
  }
  for (int k = 0; k < 20; ++k) robots.step();
  EXPECT_EQ(robots.step(), Phase::ready);
}

TEST(Staging, IsNotOverWhileARobotIsNotSeenAtItsStart) {
  AtTheStarts robots;
  for (int k = 0; k < 5; ++k) robots.step();
  for (int k = 0; k < 60; ++k) EXPECT_EQ(robots.step(1), Phase::staging) << k;
  for (int k = 0; k < 20; ++k) robots.step();
  EXPECT_EQ(robots.step(), Phase::ready) << "it is seen again";
}

TEST(Staging, StopEndsIt) {
  const Experiment e = good(paper_experiment().source, disorder);
  ControlTick tick(e);
  std::vector<core::Measurement> measured(4);
  for (std::size_t i = 0; i < 4; ++i) measured[i] = {*e.robots[i].start, 0.0};
  const OperatorCommand stage = commands::Stage{};
  TickInput input;
  input.measurements = measured;
  input.commands = {&stage, 1};
  EXPECT_EQ(tick.step(input).phase, Phase::staging);
  input.commands = {};
  input.now = 0.04;
  const TickRecord& driving = tick.step(input);
  EXPECT_TRUE(std::any_of(driving.robots.begin(), driving.robots.end(),
                          [](const RobotRecord& r) { return r.command != core::Twist{}; }));
  input.now = 0.08;
  input.stop = true;
  const TickRecord& stopped_now = tick.step(input);
  EXPECT_EQ(stopped_now.phase, Phase::stopped);
  for (const RobotRecord& robot : stopped_now.robots) EXPECT_EQ(robot.command, core::Twist{});
}

}  // namespace
}  // namespace skein::app
