// `skein identify`: runs tell what their robots really are, and a run that knows it drives as much better.
#include "app/tools/identify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/session/session.h"
#include "core/simulation/random.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"
#include "tests/places.h"

namespace skein::app {
namespace {

using core::Estimate;
using core::Unknown;
using test::Folder;
using test::Rows;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

Experiment shipped_experiment(const std::string& name, const std::vector<std::string>& sets = {}) {
  auto experiment = load_experiment(test::in_source("resources/experiments/" + name), sets);
  EXPECT_TRUE(experiment) << (experiment ? "" : experiment.error().front().message());
  return *experiment;
}

std::vector<TickRecord> rows_of(const Experiment& experiment) {
  Rows sink;
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&sink}});
  EXPECT_TRUE(session) << (session ? "" : session.error());
  if (session) (*session)->run();
  return std::move(sink.rows);
}

std::vector<RobotHistory> history_of(const Experiment& experiment) {
  RunHistory history(experiment);
  for (const TickRecord& row : rows_of(experiment)) history.record(row);
  return std::move(history).finish();
}

bool holds(const Estimate& e, double truth) {
  return e.low <= truth && truth <= e.high;
}

/// Four robots whose wheels are up to 3 % wrong, each in a way of its own, and obey late.
const std::vector<std::string> wrong_robots{
    "robot_defaults.model=epuck2",
    "robot.1.truth={wheel_diameter=0.04223, wheel_ratio=1.01, track=0.0515, actuation_delay=0.05}",
    "robot.2.truth={wheel_diameter=0.0398, wheel_ratio=0.97, track=0.0545, actuation_delay=0.03}",
    "robot.3.truth={wheel_ratio=1.03, actuation_delay=0.08}", "robot.4.truth={wheel_diameter=0.0415, track=0.0522}"};

TEST(Identify, TellsFromTheRecommendedMinuteWhatTheRobotsAre) {
  const Experiment experiment = shipped_experiment("identify.toml", wrong_robots);
  const std::vector<IdentifiedRobot> found = identify_robots(history_of(experiment));
  ASSERT_EQ(found.size(), 4u);
  int held = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const core::Identification& robot = found[i].found;
    const core::DifferentialDrive& truth = experiment.robots[i].true_drive();
    EXPECT_EQ(found[i].history.name, robot_name(experiment, i));
    EXPECT_THAT(doubts(found[i]), IsEmpty());
    EXPECT_NEAR(robot.wheel_diameter.value / truth.wheel_diameter, 1.0, 0.003);
    EXPECT_NEAR(robot.wheel_ratio.value / truth.wheel_ratio, 1.0, 0.003);
    EXPECT_NEAR(robot[Unknown::track].value / truth.track, 1.0, 0.01);
    EXPECT_NEAR(robot[Unknown::delay].value, experiment.robots[i].truth->actuation_delay, 0.01);
    EXPECT_NEAR(robot[Unknown::slip].value, experiment.simulation.slip, 0.006);
    held += holds(robot.wheel_diameter, truth.wheel_diameter) + holds(robot.wheel_ratio, truth.wheel_ratio) +
            holds(robot[Unknown::track], truth.track) +
            holds(robot[Unknown::delay], experiment.robots[i].truth->actuation_delay);
  }
  EXPECT_GE(held, 13) << "of 16 intervals of 95 %";
}

TEST(Identify, ReadsFromACsvWhatTheSessionHad) {
  test::Folder folder;
  const Experiment experiment = shipped_experiment("identify.toml", {"duration=5"});
  RunHistory direct(experiment);
  {
    std::ofstream file(folder / "run.csv");
    CsvWriter writer(file, experiment);
    for (const TickRecord& row : rows_of(experiment)) {
      writer.record(row);
      direct.record(row);
    }
  }
  const auto read = read_history(folder / "run.csv");
  ASSERT_TRUE(read) << read.error();
  const std::vector<RobotHistory> expected = std::move(direct).finish();
  EXPECT_FALSE(read->torn);
  const std::vector<RobotHistory>& robots = read->robots;
  ASSERT_EQ(robots.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(robots[i].input.poses.size(), expected[i].input.poses.size());
    ASSERT_EQ(robots[i].input.wheels.size(), expected[i].input.wheels.size());
    EXPECT_EQ(robots[i].input.poses.back().t, expected[i].input.poses.back().t);
    EXPECT_EQ(robots[i].input.poses.back().pose.x, expected[i].input.poses.back().pose.x);
    EXPECT_EQ(robots[i].input.wheels.back().left, expected[i].input.wheels.back().left);
    EXPECT_EQ(robots[i].key, "tag " + std::to_string(i + 1));
  }
  EXPECT_FALSE(read_history(folder / "none.csv"));
}

/// How far off its reference the robot really is at the end of a way on which nobody corrects it. [m]
double blind_drift(const std::vector<std::string>& sets) {
  const std::vector<TickRecord> rows = rows_of(shipped_experiment("open-loop.toml", sets));
  EXPECT_GT(rows.size(), 1000u);
  if (rows.empty()) return none;
  const RobotRecord& robot = rows.back().robots[0];
  return std::hypot(robot.truth.x - robot.nominal.pose.x, robot.truth.y - robot.nominal.pose.y);
}

/// The control is the same robot, driven by somebody who has not looked. What a minute tells depends on how the wheels
/// happened to slip: several are tried, each by itself.
TEST(Identify, CutsTheDriftOfARobotThatNobodyCorrects) {
  const std::string truth = "robot.1.truth={wheel_diameter=0.04223, wheel_ratio=1.03, track=0.0515}";
  for (const std::string link : {"sim", "loopback"}) {
    const std::vector<std::string> robot{truth, "robot.1.model=epuck2", "robot.1.link=" + link};
    const double before = blind_drift(robot);
    EXPECT_GT(before, 0.5);
    for (int minute = 1; minute <= (link == "sim" ? 8 : 1); ++minute) {
      auto learning = robot;
      learning.push_back("seed=" + std::to_string(minute));
      std::vector<RobotHistory> history = history_of(shipped_experiment("identify.toml", learning));
      ASSERT_EQ(history.size(), 4u);
      history.resize(1);
      const IdentifiedRobot found = identify_robots(std::move(history)).front();
      auto knowing = robot;
      for (const auto& [key, value] : values_to_keep(found)) knowing.push_back("robot.1." + key + "=" + value);
      ASSERT_EQ(knowing.size(), robot.size() + 4) << "diameter, ratio, track and delay were found";
      const double after = blind_drift(knowing);
      std::cout << "drift_" << link << ": " << 1e3 * before << " mm without, " << 1e3 * after << " mm with, "
                << before / after << " times less\n";
      EXPECT_GE(before / after, 20.0) << link << ", seed " << minute;
    }
  }
}

TEST(Identify, PassesOverHands) {
  auto sets = wrong_robots;
  for (const char* set :
       {"perturb.1={t=20, robot=1, dx=0.1, dtheta=0.5}", "operator.1={t=30, does=\"kick r1 vx=0.4 vy=0\"}",
        "operator.2={t=40, does=\"move r1 x=-0.5 y=0.3 theta=1\"}"})
    sets.emplace_back(set);
  const Experiment experiment = shipped_experiment("identify.toml", sets);
  std::vector<RobotHistory> history = history_of(experiment);
  EXPECT_GE(history[0].carried, 3u);
  EXPECT_EQ(history[1].carried, 0u);
  history.resize(1);
  const IdentifiedRobot found = identify_robots(std::move(history)).front();
  const core::DifferentialDrive& truth = experiment.robots[0].true_drive();
  EXPECT_THAT(doubts(found), IsEmpty());
  EXPECT_EQ(found.outliers, 0u);
  EXPECT_NEAR(found.found.wheel_diameter.value / truth.wheel_diameter, 1.0, 0.003);
  EXPECT_NEAR(found.found[Unknown::track].value / truth.track, 1.0, 0.01);
}

/// Of a CSV from which rows were taken: a gap, and every second one. The commands of those rows are not known.
TEST(Identify, DoesNotGuessTheCommandsOfRowsThatAreMissing) {
  const Experiment experiment = shipped_experiment("identify.toml", wrong_robots);
  const std::vector<TickRecord> rows = rows_of(experiment);
  ASSERT_GT(rows.size(), 1000u);
  const auto history_without = [&](const auto& missing) {
    RunHistory history(experiment);
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (!missing(k)) history.record(rows[k]);
    const std::size_t gaps = history.gaps();
    return std::pair(std::move(history).finish(), gaps);
  };
  EXPECT_EQ(history_without([](std::size_t) { return false; }).second, 0u) << "the control";

  auto [cut, one] = history_without([](std::size_t k) { return k >= 500 && k < 700; });
  EXPECT_EQ(one, 1u);
  const auto found = identify_robots(std::move(cut));
  for (std::size_t i = 0; i < found.size(); ++i) {
    const core::DifferentialDrive& truth = experiment.robots[i].true_drive();
    EXPECT_NEAR(found[i].found.wheel_diameter.value / truth.wheel_diameter, 1.0, 0.003);
    EXPECT_NEAR(found[i].found[Unknown::track].value / truth.track, 1.0, 0.01);
    EXPECT_EQ(found[i].outliers, 0u);
  }

  auto [thinned, many] = history_without([](std::size_t k) { return k % 2 == 1; });
  EXPECT_GT(many, rows.size() / 3);
  for (const IdentifiedRobot& robot : identify_robots(std::move(thinned))) {
    EXPECT_THAT(values_to_keep(robot), IsEmpty());
    EXPECT_THAT(doubts(robot), Not(IsEmpty()));
  }
}

/// Its ticks have no rows either, but none is missing.
TEST(Identify, APauseIsNoGap) {
  const Experiment experiment = shipped_experiment("identify.toml", wrong_robots);
  RunHistory history(experiment);
  std::size_t k = 0;
  for (TickRecord row : rows_of(experiment)) {
    if (k++ >= 500) {  // paused for 7 s
      row.now += 7.0;
      for (RobotRecord& robot : row.robots) robot.measurement.captured_at += 7.0;
    }
    history.record(row);
  }
  EXPECT_EQ(history.gaps(), 0u);
  const IdentifiedRobot found = identify_robots(std::move(history).finish()).front();
  const core::DifferentialDrive& truth = experiment.robots[0].true_drive();
  EXPECT_NEAR(found.found.wheel_diameter.value / truth.wheel_diameter, 1.0, 0.003);
  EXPECT_NEAR(found.found[Unknown::track].value / truth.track, 1.0, 0.01);
  EXPECT_EQ(found.outliers, 0u);
}

/// A record and a copy of it that a full disk cut short, say: together they would make the intervals narrower.
TEST(Identify, KnowsARunAgainWhereverItsFileEnds) {
  const Folder folder;
  const Experiment experiment = shipped_experiment("identify.toml", {"duration=4"});
  {
    std::ofstream file(folder / "run.csv");
    CsvWriter writer(file, experiment);
    for (const TickRecord& row : rows_of(experiment)) writer.record(row);
  }
  std::filesystem::copy_file(folder / "run.csv", folder / "torn.csv");
  std::filesystem::resize_file(folder / "torn.csv", std::filesystem::file_size(folder / "run.csv") - 57);
  const auto whole = read_history(folder / "run.csv"), torn = read_history(folder / "torn.csv");
  ASSERT_TRUE(whole && torn);
  ASSERT_TRUE(torn->torn);
  EXPECT_THAT(*torn->torn, HasSubstr("torn here"));
  EXPECT_TRUE(same_run(whole->robots, torn->robots));
  EXPECT_TRUE(same_run(torn->robots, whole->robots));
  EXPECT_FALSE(same_run(whole->robots, history_of(shipped_experiment("identify.toml", {"duration=4", "seed=2"}))));
}

/// Of residuals that grow: here the last ones of poses without noise.
TEST(Identify, TheCorrelationOfResidualsIsOne) {
  for (const IdentifiedRobot& robot : identify_robots(history_of(shipped_experiment("platoon.toml", {"duration=20"}))))
    EXPECT_LE(std::abs(robot.persistence), 1.0) << robot.history.name;
}

TEST(Identify, SeveralRunsTellMoreThanOne) {
  std::vector<RobotHistory> one = history_of(shipped_experiment("identify.toml", wrong_robots)), both = one;
  auto later = wrong_robots;
  later.emplace_back("seed=2");
  append(both, history_of(shipped_experiment("identify.toml", later)));
  ASSERT_EQ(both.size(), 4u);
  EXPECT_EQ(both[2].runs, 2u);
  const auto alone = identify_robots(std::move(one)), together = identify_robots(std::move(both));
  for (std::size_t i = 0; i < 4; ++i) {
    const auto width = [](const Estimate& e) { return e.high - e.low; };
    EXPECT_NEAR(width(together[i].found[Unknown::track]) / width(alone[i].found[Unknown::track]), std::sqrt(0.5), 0.1);
    EXPECT_NEAR(together[i].found.driven / alone[i].found.driven, 2.0, 0.02);
    EXPECT_EQ(together[i].outliers, 0u) << "the way from one run to the next is nobody's";
  }
}

/// The mean of two robots is neither of them, and its interval is as narrow as if there were one.
TEST(Identify, NamesRunsOfAnotherRobotWithTheSameTag) {
  auto robots = history_of(shipped_experiment("identify.toml", wrong_robots));
  std::vector<std::string> later = wrong_robots;
  later.emplace_back("seed=2");
  later[2] = "robot.2.truth={wheel_diameter=0.0398, wheel_ratio=0.985, track=0.0545, actuation_delay=0.03}";
  append(robots, history_of(shipped_experiment("identify.toml", later)));
  const auto found = identify_robots(std::move(robots));
  EXPECT_THAT(doubts(found[1]), ::testing::Contains(AllOf(HasSubstr("run 2 of 2 alone gives wheel_ratio 0.98"),
                                                          HasSubstr("another robot with the same name or tag"))));
  EXPECT_THAT(values_to_keep(found[1]), IsEmpty());
  for (const std::size_t same : {0, 2, 3}) {
    EXPECT_THAT(doubts(found[same]), IsEmpty()) << same;
    EXPECT_THAT(values_to_keep(found[same]), Not(IsEmpty())) << same;
  }
}

TEST(Identify, RunsInOtherStepsAreOneRobotAllTheSame) {
  auto robots = history_of(shipped_experiment("identify.toml", wrong_robots));
  auto finer = robots;
  for (RobotHistory& robot : finer) {
    robot.input.believed.steps_per_turn *= 2.0;
    for (core::WheelKnot& knot : robot.input.wheels) knot.left *= 2.0, knot.right *= 2.0;
  }
  append(robots, finer);
  for (const IdentifiedRobot& robot : identify_robots(std::move(robots))) EXPECT_THAT(doubts(robot), IsEmpty());
}

TEST(Identify, ARunWithoutNoiseIsNotSaidToBeOfAnotherRobot) {
  auto robots = history_of(shipped_experiment("identify.toml"));
  append(robots, history_of(shipped_experiment("platoon.toml")));
  for (const IdentifiedRobot& robot : identify_robots(std::move(robots))) {
    EXPECT_EQ(robot.history.runs, 2u);
    EXPECT_THAT(robot.others, IsEmpty());
  }
}

TEST(Identify, NamesARobotThatStandsThoughItIsToldToDrive) {
  std::vector<RobotHistory> history = history_of(shipped_experiment("identify.toml", {}));
  ASSERT_EQ(history.size(), 4u);
  core::Random noise(1, 0);
  std::vector<core::SeenPose>& poses = history[1].input.poses;
  for (core::SeenPose& seen : poses)
    seen.pose = {poses.front().pose.x + 0.001 * noise.gaussian(), poses.front().pose.y + 0.001 * noise.gaussian(),
                 poses.front().pose.theta + 0.005 * noise.gaussian()};
  const auto found = identify_robots(std::move(history));
  EXPECT_THAT(doubts(found[1]), ElementsAre(HasSubstr("it stood though it was commanded to drive")));
  EXPECT_THAT(values_to_keep(found[1]), IsEmpty());
  EXPECT_THAT(doubts(found[0]), IsEmpty()) << "the control: one that drives";
}

TEST(Identify, SaysWhatARunCannotTell) {
  const std::vector<std::string> straight{
      "duration=12", "robot.1.trajectory={path={shape=\"line\", from=[-0.5, 0.0], to=[0.5, 0.0]}}"};
  Experiment experiment = shipped_experiment("open-loop.toml", straight);
  experiment.simulation = {.pose_noise = 0.0005, .heading_noise = 0.006, .slip = 0.02};
  const auto found = identify_robots(history_of(experiment));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_THAT(doubts(found[0]),
              ::testing::Contains(AllOf(HasSubstr("do not determine the track"),
                                        HasSubstr(" rad of turning: turn more"), Not(HasSubstr("e-")))));
  for (const auto& [key, value] : values_to_keep(found[0])) EXPECT_NE(key, "track") << value;

  const Experiment standing = shipped_experiment(
      "open-loop.toml", {"duration=3", "robot.1.trajectory={t=100, path={shape=\"line\", from=[0,0], to=[1,0]}}"});
  const auto stood = identify_robots(history_of(standing));
  ASSERT_EQ(stood.size(), 2u);
  EXPECT_THAT(doubts(stood[0]), ElementsAre(HasSubstr("it never drove")));
  EXPECT_THAT(values_to_keep(stood[0]), IsEmpty());

  const auto once = identify_robots(history_of(shipped_experiment("open-loop.toml", {"duration=0.04"})));
  EXPECT_THAT(doubts(once[0]), ElementsAre(HasSubstr("it never drove, in 1 pose: ")));
}

TEST(Identify, DrawsOfALongRunAsManyResidualsAsCanBeSeen) {
  const Folder folder;
  IdentifiedRobot robot;
  robot.history.name = "robot 1";
  for (int k = 0; k < 90'000; ++k)
    robot.found.innovations.push_back({0.04 * k, 1e-3 * std::sin(k), 0.0, 0.0, 1.0, true});
  robot.found.innovations[77'777].used = false;
  const auto drawn = write_residuals(folder.path, {robot});
  ASSERT_TRUE(drawn) << drawn.error();
  EXPECT_LT(std::filesystem::file_size(folder / "residuals_1.svg"), 6u << 20);
  EXPECT_GT(std::filesystem::file_size(folder / "residuals_1.csv"), 90'000u * 20) << "the data has all of them";
}

/// A link writes a tick's speeds a little later, which is part of the delay; but when it holds them back, they count
/// from when they were written, and what it did not write does not count.
TEST(Identify, GoesByWhatTheLinkHasSent) {
  Experiment experiment = shipped_experiment("open-loop.toml");
  RunHistory history(experiment);
  TickRecord row;
  row.robots.resize(2);
  RobotRecord& robot = row.robots[0];
  const auto tick = [&](double now, double told, double sent, double sent_at) {
    row.now = now;
    robot.wheels = {told, told};
    robot.link.input = {.linked = true, .sent = {sent, sent}, .sent_at = sent_at, .blind_way = 0.0};
    robot.measurement = {{now, 0.0, 0.0}, now, 0.0, 0.0};
    history.record(row);
  };
  tick(0.0, 100, none, none);
  tick(1.0, 200, 100, 0.1);
  tick(2.0, 300, 200, 1.1);
  tick(3.0, 300, 0, 2.4);  // stopped by the link
  tick(4.0, 300, 0, 2.4);
  const std::vector<RobotHistory> all = std::move(history).finish();
  ASSERT_EQ(all.size(), 1u);
  const auto way_by = [&](double t) {
    double way = 0.0;
    for (const core::WheelKnot& knot : all[0].input.wheels)
      if (knot.t <= t + 1e-9) way = knot.left;
    return way;
  };
  EXPECT_NEAR(way_by(1.0), 100.0, 5.0);
  EXPECT_NEAR(way_by(2.4), 100.0 + 1.4 * 200.0, 5.0);
  EXPECT_NEAR(way_by(4.0), 100.0 + 1.4 * 200.0, 5.0);
}

}  // namespace
}  // namespace skein::app
