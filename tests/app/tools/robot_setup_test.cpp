// Robots that are being set up: what the next step of each is, and the work that finds it out.
#include "app/tools/robot_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <thread>
#include <utility>

#include "app/guard/run_marker.h"
#include "app/tools/robot_ping.h"
#include "app/tools/robot_setup_work.h"
#include "comms/emulator/pty_emulator.h"
#include "tests/app/experiment_texts.h"
#include "tests/stall.h"

namespace skein::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using State = SetupVerdict::State;
using Kind = SetupTask::Kind;

constexpr const char* anna_and_bert =
    "[robot_defaults]\nlink = \"loopback\"\n"
    "[[robot]]\nname = \"anna\"\nstart = [-0.4, 0.2, 0.5]\n[[robot]]\nname = \"bert\"\nstart = [0.3, -0.2, 2.0]\n";

/// Emulated robots behind lines as of real ones.
struct Lab {
  explicit Lab(std::size_t count)
      : robots(
            std::vector<core::MotorModel>(count, core::MotorModel::epuck2),
            [this](std::size_t, const core::WheelSpeeds& told) {
              if (told.left != 0 || told.right != 0) driven = true;
            },
            [] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }) {
  }
  Experiment experiment(const std::string& second = {}) const {
    Experiment e;
    for (std::size_t k = 0; k < 2; ++k) {
      RobotSpec& robot = e.robots.emplace_back();
      robot.link = RobotSpec::Link::device;
      robot.tag = static_cast<int>(k) + 1;
      robot.address = "serial:" + (k == 1 && !second.empty() ? second : robots.device(k % robots.size()));
      robot.name = k == 0 ? "anna" : "bert";
      robot.type = core::find_robot_type("epuck2");
    }
    return e;
  }
  /// Before the robots are: markers of guards stay among the tests.
  bool apart = ::setenv("XDG_STATE_HOME", (testing::TempDir() + "robot-setup-state").c_str(), 1) == 0;
  std::atomic<bool> driven{false};
  comms::PtyEmulator robots;
};

std::vector<std::pair<std::size_t, RobotSetup>> all_of(const Experiment& experiment) {
  std::vector<std::pair<std::size_t, RobotSetup>> all;
  for (const RobotSetup& robot : setups_of(experiment)) all.emplace_back(all.size(), robot);
  return all;
}

/// What the work has found when it is over; looked at often, as by a window that does not hang.
SetupNews outcome(SetupWork& work) {
  SetupNews all;
  while (!all.over) {
    static_cast<void>(work.wait(0.02));
    SetupNews more = work.news();
    all.over = more.over;
    all.problem = std::move(more.problem);
    std::move(more.robots.begin(), more.robots.end(), std::back_inserter(all.robots));
    std::move(more.warnings.begin(), more.warnings.end(), std::back_inserter(all.warnings));
  }
  return all;
}

/// What a test of all robots has found, by the way that `watched` looks at it.
SetupNews tested(const Experiment& experiment, SetupNews (*watched)(SetupWork&) = outcome) {
  return skein::test::unless_stalled(
      [&] {
        SetupWork work({Kind::test, {}, experiment, all_of(experiment)});
        return watched(work);
      },
      [](const SetupNews& news) {
        return news.robots.empty() ? std::string() : news.robots.back().second.test_problem;
      });
}

TEST(RobotSetup, SaysTheNextStepInTheOrderInWhichStepsAreTaken) {
  RobotSetup robot;
  robot.number = 0;
  EXPECT_EQ(verdict_on(robot, true).state, State::ready) << "it is simulated";
  robot.spec.link = RobotSpec::Link::device;
  robot.spec.address = "rfcomm:10:00:E8:AA:BB:CC/1";
  robot.paired = false;
  EXPECT_EQ(verdict_on(robot, true).sentence, "pair it");
  robot.paired = true;
  EXPECT_EQ(verdict_on(robot, true).sentence, "ping it");
  robot.pinged = true;
  robot.silence = "host is down";
  EXPECT_EQ(verdict_on(robot, true).state, State::wrong);
  EXPECT_THAT(verdict_on(robot, true).sentence, HasSubstr("does not answer: host is down"));
  robot.answers = true;
  robot.battery_low = true;
  EXPECT_THAT(verdict_on(robot, true).sentence, HasSubstr("charge"));
  robot.battery_low = false;
  EXPECT_EQ(verdict_on(robot, true).sentence, "test its wheels and its tag");
  EXPECT_EQ(verdict_on(robot, false).sentence, "test its wheels");
  robot.test_problem = "stopped";
  EXPECT_EQ(verdict_on(robot, true).state, State::missing);
  EXPECT_THAT(verdict_on(robot, true).sentence, HasSubstr("stopped"));
  robot.test_problem.clear();
  robot.test = RobotTestResult{};
  robot.test->faults = {"the wheels are swapped", "another", "a third"};
  EXPECT_EQ(verdict_on(robot, true).state, State::wrong);
  EXPECT_EQ(verdict_on(robot, true).sentence, "the wheels are swapped, and 2 faults more: see below");
  robot.test->faults.clear();
  EXPECT_EQ(verdict_on(robot, true).sentence, "ready");
  EXPECT_EQ(verdict_on(robot, true).state, State::ready);
  robot.number = -1;
  EXPECT_THAT(verdict_on(robot, true).sentence, HasSubstr("add it"));
  robot.may_drive = true;
  EXPECT_EQ(verdict_on(robot, true).state, State::wrong) << "before all else";
  EXPECT_THAT(verdict_on(robot, true).sentence, HasSubstr("NOT acknowledged"));
}

TEST(RobotSetup, AScanTellsWhoIsPairedAndAddsWhoIsNotThere) {
  Experiment experiment;
  RobotSpec& anna = experiment.robots.emplace_back();
  anna.name = "anna";
  anna.link = RobotSpec::Link::device;
  anna.address = "rfcomm:10:00:e8:aa:bb:01";
  std::vector<RobotSetup> robots = setups_of(experiment);
  add_found(robots,
            {{"e-puck_1234", "10:00:E8:AA:BB:01", "hci0", true}, {"e-puck2_04567", "30:AE:A4:AA:BB:02", "hci1"}});
  ASSERT_EQ(robots.size(), 2u);
  EXPECT_EQ(robots[0].paired, true);
  EXPECT_EQ(robots[1].number, -1);
  EXPECT_EQ(robots[1].spec.address, "rfcomm:30:AE:A4:AA:BB:02/2");
  EXPECT_EQ(robots[1].spec.adapter, "hci1");
  EXPECT_EQ(robots[1].paired, false);
  add_found(robots, {{"e-puck2_04567", "30:AE:A4:AA:BB:02", "hci1", true}});
  ASSERT_EQ(robots.size(), 2u) << "it is there already";
  EXPECT_EQ(robots[1].paired, true);
  // Another experiment with the same robot: what is known of it stays, and the one that was found.
  robots[0].answers = true;
  const std::vector<RobotSetup> again = setups_of(experiment, robots);
  ASSERT_EQ(again.size(), 2u);
  EXPECT_TRUE(again[0].answers);
  EXPECT_EQ(again[1].name, "e-puck2_04567");
  EXPECT_EQ(setups_of(Experiment{}, robots).size(), 1u) << "only the one that belongs to no experiment";
}

TEST(RobotPing, TellsOfEmulatedRobotsWhatOfRealOnes) {
  const auto ping = ping_robots(good(anna_and_bert), {.seconds = 0.4});
  ASSERT_TRUE(ping) << ping.error();
  ASSERT_EQ(ping->robots.size(), 2u);
  for (const RobotPing::Robot& robot : ping->robots) {
    EXPECT_TRUE(robot.answered());
    EXPECT_TRUE(robot.stop_acknowledged);
    EXPECT_EQ(robot.status.version, "Version 2.0 January 2018 GCtronic");
    EXPECT_FALSE(std::isnan(robot.status.battery.volts));
  }
}

TEST(SetupWork, PingsWhoAnswersAndNamesWhoDoesNot) {
  const Lab lab(1);
  const Experiment experiment = lab.experiment("/dev/no-such-robot");
  EXPECT_FALSE(ping_robots(experiment, {.seconds = 0.1})) << "the control: a run needs all of them";
  SetupWork work({Kind::ping, {}, experiment, all_of(experiment)});
  const SetupNews news = outcome(work);
  EXPECT_EQ(news.problem, "");
  ASSERT_EQ(news.robots.size(), 2u);
  EXPECT_TRUE(news.robots[0].second.answers);
  EXPECT_GT(news.robots[0].second.exchanges, 20u);
  EXPECT_THAT(news.robots[0].second.battery, HasSubstr("V"));
  EXPECT_FALSE(news.robots[1].second.answers);
  EXPECT_TRUE(news.robots[1].second.pinged);
  EXPECT_THAT(news.robots[1].second.silence, HasSubstr("no-such-robot"));
  EXPECT_FALSE(lab.driven) << "nobody drives";
}

TEST(SetupWork, TestsWheelsTagsAndWatchdogs) {
  const Experiment experiment = good(anna_and_bert, {"camera.source=synthetic", "rate=10"});
  SetupWork work({Kind::test, {}, experiment, all_of(experiment)});
  const SetupNews news = outcome(work);
  EXPECT_EQ(news.problem, "");
  ASSERT_EQ(news.robots.size(), 2u);
  for (const auto& [row, robot] : news.robots) {
    ASSERT_TRUE(robot.test) << robot.name;
    EXPECT_THAT(robot.test->faults, IsEmpty()) << robot.name;
    EXPECT_EQ(robot.test->tag, robot.spec.tag);
    EXPECT_TRUE(robot.test->wheel_diameter) << robot.name;
    EXPECT_EQ(verdict_on(robot, true).sentence, "ready");
  }
}

TEST(SetupWork, StopStandsTheRobotThatDrivesAndTestsNobodyElse) {
  Lab lab(2);
  const Experiment experiment = lab.experiment();
  SetupWork work({Kind::test, {}, experiment, all_of(experiment)});
  while (!lab.driven && !work.wait(0.002)) static_cast<void>(work.news());
  ASSERT_TRUE(lab.driven) << work.news().problem;
  work.stop();
  const SetupNews news = outcome(work);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(lab.robots.wheels(k).left, 0.0);
    EXPECT_EQ(lab.robots.wheels(k).right, 0.0);
  }
  ASSERT_EQ(news.robots.size(), 1u) << "the other one was not begun with";
  EXPECT_EQ(news.robots[0].second.test_problem, "stopped");
  EXPECT_FALSE(news.robots[0].second.may_drive) << "it has acknowledged its stop";
}

TEST(SetupWork, NobodyDrivesForAWindowThatHangs) {
  const Lab lab(2);
  const Experiment experiment = lab.experiment();
  const SetupNews news = tested(experiment, [](SetupWork& work) {
    EXPECT_TRUE(work.wait(60.0)) << "nobody has looked at it";
    return work.news();
  });
  ASSERT_FALSE(news.robots.empty());
  EXPECT_EQ(news.robots.back().second.test_problem, "stopped");
  EXPECT_FALSE(news.robots.back().second.may_drive);
  EXPECT_EQ(lab.robots.wheels(0).left, 0.0);
}

TEST(SetupWork, ARobotThatIsNotThereDoesNotKeepTheOthersFromTheirTest) {
  const Lab lab(1);
  Experiment experiment = lab.experiment("/dev/no-such-robot");
  std::swap(experiment.robots[0], experiment.robots[1]);
  const SetupNews news = tested(experiment);
  ASSERT_EQ(news.robots.size(), 2u);
  EXPECT_FALSE(news.robots[0].second.answers);
  EXPECT_THAT(news.robots[0].second.silence, HasSubstr("no-such-robot"));
  ASSERT_TRUE(news.robots[1].second.test) << news.robots[1].second.test_problem;
  EXPECT_THAT(news.robots[1].second.test->faults, IsEmpty());
  EXPECT_EQ(news.robots[1].second.test->watchdog, 0.0) << "an e-puck has none";
}

TEST(SetupWork, ACameraThatIsNotThereIsNoRobotThatDoesNotAnswer) {
  const Lab lab(2);
  Experiment experiment = lab.experiment();
  experiment.camera.source = "v4l2:/dev/no-such-camera";
  experiment.camera.calibration = "overhead.toml";
  experiment.directory = skein::test::in_source("resources/cameras");
  SetupWork work({Kind::test, {}, experiment, all_of(experiment)});
  const SetupNews news = outcome(work);
  EXPECT_THAT(news.problem, HasSubstr("no-such-camera"));
  ASSERT_EQ(news.robots.size(), 1u) << "the other robot has no camera either";
  EXPECT_EQ(news.robots[0].second.silence, "");
  EXPECT_THAT(verdict_on(news.robots[0].second, true).sentence, ::testing::Not(HasSubstr("does not answer")));
  EXPECT_FALSE(lab.driven);
}

TEST(SetupWork, IsLetGoOfWhileItDrives) {
  Lab lab(2);
  Experiment experiment = lab.experiment();
  experiment.name = "let go of";
  {
    SetupWork work({Kind::test, {}, experiment, all_of(experiment)});
    while (!lab.driven && !work.wait(0.002)) static_cast<void>(work.news());
  }
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  const auto is_guarded = [] {
    const std::vector<RunMarker> all = all_markers();
    return std::any_of(all.begin(), all.end(), [](const RunMarker& run) { return run.experiment == "let go of"; });
  };
  while (is_guarded() && std::chrono::steady_clock::now() < give_up) std::this_thread::yield();
  EXPECT_FALSE(is_guarded()) << "the guard still looks after it";
  EXPECT_EQ(lab.robots.wheels(0).left, 0.0);
  EXPECT_EQ(lab.robots.wheels(0).right, 0.0);
}

TEST(RobotSetup, IsSavedInTheFileOfRobots) {
  const std::filesystem::path home = std::filesystem::path(testing::TempDir()) / "robot-setup";
  std::filesystem::remove_all(home);
  const char* const before = std::getenv("XDG_CONFIG_HOME");
  const std::string old = before ? before : "";
  ::setenv("XDG_CONFIG_HOME", home.c_str(), 1);
  RobotSetup anna;
  anna.name = "robot 1 (anna)";
  anna.spec.name = "anna";
  anna.spec.tag = 1;
  anna.spec.link = RobotSpec::Link::device;
  anna.spec.address = "rfcomm:10:00:e8:aa:bb:01";
  anna.spec.type = core::find_robot_type("epuck1");
  EXPECT_FALSE(save({RobotSetup{}})) << "it is simulated";
  anna.test = RobotTestResult{};
  anna.test->wheel_diameter = 0.0412;
  RobotSetup nameless = anna;
  nameless.spec.name.clear();
  const auto saved = save({anna, nameless});
  ASSERT_TRUE(saved) << saved.error();
  EXPECT_EQ(saved->added, 1u);
  EXPECT_THAT(saved->problems, ElementsAre(HasSubstr("has no name")));
  const auto known = load_known_robots((home / "skein/robots.toml").string());
  ASSERT_TRUE(known);
  ASSERT_EQ(known->size(), 1u);
  EXPECT_EQ(known->front().spec.address, "rfcomm:10:00:E8:AA:BB:01/1");
  EXPECT_DOUBLE_EQ(known->front().spec.drive.wheel_diameter, 0.0412);
  anna.test->faults = {"the wheels are swapped"};
  anna.test->wheel_diameter = 0.05;
  const auto again = save({anna});
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->added, 0u) << "it is there";
  EXPECT_DOUBLE_EQ(load_known_robots(again->file)->front().spec.drive.wheel_diameter, 0.0412)
      << "what a robot with faults measured is worth nothing";
  old.empty() ? ::unsetenv("XDG_CONFIG_HOME") : ::setenv("XDG_CONFIG_HOME", old.c_str(), 1);
  std::filesystem::remove_all(home);
}

}  // namespace
}  // namespace skein::app
