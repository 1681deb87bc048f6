// robots.toml on the command line: robots that are tested, listed and stopped by their names.
#include "app/experiment/known_robots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "app/cli/command_line_runs.h"
#include "app/cli/commands.h"
#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/run/exit_status.h"
#include "app/run/resources.h"
#include "app/session/session.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/link_supervisor.h"
#include "tests/app/folder.h"
#include "tests/places.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class KnownRobotsCommands : public ::testing::Test {
 public:
  KnownRobotsCommands() {
    write("robots.toml",
          "[[robot]]\nname = \"anna\"\nlink = \"rfcomm:10:00:e8:aa:bb:cc/1\"\ntag = 7\nmodel = \"epuck1\"\n\n"
          "[[robot]]\nname = \"bert\"\nlink = \"tcp:192.168.1.20\"\n");
  }
  std::string path(const std::string& name) const { return (directory / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }

  const test::Folder own_folder;
  const fs::path directory = own_folder.path;
};

/// `--save` of an experiment by its name would change it for all users of the machine.
TEST_F(KnownRobotsCommands, NothingIsSavedInAnExperimentThatComesWithSkein) {
  const std::string shipped = find_resource("experiments", "platoon-loopback");
  ASSERT_TRUE(fs::exists(shipped)) << shipped;
  EXPECT_FALSE(can_save_keys(shipped, {{"camera.latency", "0.0300"}}));
  fs::copy_file(shipped, path("mine.toml"));
  EXPECT_TRUE(can_save_keys(path("mine.toml"), {{"camera.latency", "0.0300"}})) << "the control";
}

/// Each reads the file, changes its robot in it and writes it, again and again: what it has written stays.
TEST_F(KnownRobotsCommands, NothingIsLostOfWhatTwoProgramsSaveAtTheSameTime) {
  constexpr int rounds = 100;
  const auto program = [&](std::size_t number) {
    if (!std::freopen("/dev/null", "w", stdout)) return 3;
    for (int round = 1; round <= rounds; ++round) {
      FoundRobot found;
      found.spec.name = found.name = number == 0 ? "anna" : "bert";
      found.values = {{"tag", std::to_string(2 * round + static_cast<int>(number))}};
      if (save_found(path("robots.toml"), {found}) != done) return 1;
      const auto known = load_known_robots(path("robots.toml"));
      if (!known || known->at(number).spec.tag != 2 * round + static_cast<int>(number)) return 2;
    }
    return 0;
  };
  std::array<pid_t, 2> processes{};
  for (std::size_t k = 0; k < processes.size(); ++k)
    if ((processes[k] = ::fork()) == 0) ::_exit(program(k));
  for (const pid_t process : processes) {
    int status = -1;
    ASSERT_EQ(::waitpid(process, &status, 0), process);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 0) << "1: not saved, 2: what it saved was gone";
  }
}

TEST_F(KnownRobotsCommands, TestedOnesAreSaved) {
  write("loopback.toml",
        "rate = 10\n[robot_defaults]\nlink = \"loopback\"\n[camera]\nsource = \"synthetic\"\n[[robot]]\nname = "
        "\"anna\"\ntag = 9\nwheel_diameter = 0.0415\n");
  testing::internal::CaptureStdout();
  RobotsRequest request;
  request.words = {path("loopback.toml")};
  request.file = path("robots.toml");
  request.save = true;
  EXPECT_EQ(test_robots(request), done);
  EXPECT_EQ(list_robots(path("robots.toml")), done);
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_THAT(said, HasSubstr("robot 1 (anna): emulated\nversion: Version 2.0 January 2018 GCtronic\n"));
  EXPECT_THAT(said, HasSubstr("\ntag: 9\nwheel_diameter: 0.041"));
  EXPECT_THAT(said, HasSubstr("tcp:192.168.1.20:1000"));
  const auto known = load_known_robots(path("robots.toml"));
  ASSERT_TRUE(known);
  EXPECT_EQ(known->at(0).version, "Version 2.0 January 2018 GCtronic");
  EXPECT_EQ(known->at(0).spec.tag, 9);
  EXPECT_NEAR(known->at(0).spec.drive.wheel_diameter / 0.0415, 1.0, 0.005);
  EXPECT_NEAR(known->at(0).spec.drive.track / 0.053, 1.0, 0.005);
}

TEST_F(KnownRobotsCommands, AreIdentifiedFromARunAndTheNextRunKnows) {
  const auto e =
      load_experiment(test::in_source("resources/experiments/identify.toml"),
                      {"robot.1.name=anna", "robot.2.name=carl", "robot.1.model=epuck1",
                       "robot.1.truth={wheel_diameter=0.0422, wheel_ratio=1.01, track=0.0515, actuation_delay=0.05}"});
  ASSERT_TRUE(e) << e.error().front().message();
  {
    std::ofstream file(path("run.csv"));
    CsvWriter writer(file, *e);
    auto session = Session::open(*e, Session::Clock::virtual_, {false, {&writer}});
    ASSERT_TRUE(session) << session.error();
    (*session)->run();
  }
  IdentifyRequest request;
  request.runs = {path("run.csv")};
  request.file = path("robots.toml");
  request.report = path("residuals");
  request.save = true;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EXPECT_EQ(identify(request), done);
  const std::string said = testing::internal::GetCapturedStdout(), errors = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("robot 1 (anna)\nruns: 1\nposes: 15"));
  EXPECT_THAT(said, HasSubstr("believed 0.041"));
  EXPECT_THAT(errors, HasSubstr("robot 2 (carl) is not in " + path("robots.toml") + ": none of its values was saved"));
  EXPECT_GT(fs::file_size(path("residuals/residuals_1.svg")), 10000u);

  write("e.toml", "robots_file = \"robots.toml\"\n[[robot]]\nname = \"anna\"\nlink = \"sim\"\n[[robot]]\ntag = 2\n");
  const auto next = load_experiment(path("e.toml"));
  ASSERT_TRUE(next) << next.error().front().message();
  const RobotSpec& anna = next->robots.at(0);
  EXPECT_NEAR(anna.drive.wheel_diameter / 0.0422, 1.0, 0.003);
  EXPECT_NEAR(anna.drive.wheel_ratio / 1.01, 1.0, 0.003);
  EXPECT_NEAR(anna.drive.track / 0.0515, 1.0, 0.01);
  EXPECT_NEAR(anna.actuation_delay.value_or(0.0), 0.05, 0.01);
  EXPECT_EQ(next->robots.at(1).drive.wheel_ratio, 1.0);

  write("others.toml", "[[robot]]\nname = \"dora\"\nlink = \"serial:/dev/nowhere\"\n");
  request.file = path("others.toml");
  testing::internal::CaptureStdout();
  EXPECT_EQ(identify(request), expectation_failed) << "none of its robots could be saved";
  testing::internal::GetCapturedStdout();

  fs::copy_file(path("run.csv"), path("copy.csv"));
  request.runs = {path("run.csv"), path("copy.csv")};
  testing::internal::CaptureStderr();
  EXPECT_EQ(identify(request), wrong_input);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("copy.csv: is the same run as " + path("run.csv")));

  request.runs = {path("robots.toml")};
  testing::internal::CaptureStderr();
  EXPECT_EQ(identify(request), wrong_input);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("robots.toml"));
}

TEST_F(KnownRobotsCommands, AreStoppedByNameAndAllOfThem) {
  comms::PtyEmulator robots({core::MotorModel::epuck1, core::MotorModel::epuck2}, nullptr, [] { return 0.0; });
  write("robots.toml", "[[robot]]\nname = \"anna\"\nlink = \"serial:" + robots.device(0) +
                           "\"\n[[robot]]\nname = \"bert\"\nlink = \"serial:" + robots.device(1) + "\"\n");
  ::setenv("XDG_STATE_HOME", path("state").c_str(), 1);  // no run has left anything there
  const auto drive_off = [&] {
    comms::LinkSupervisor links({{comms::LinkKind::serial, robots.device(0), 0, {}, {}},
                                 {comms::LinkKind::serial, robots.device(1), 0, {}, {}}},
                                {.command_silence = 0.0, .close_timeout = 0.0});
    ASSERT_TRUE(links.start(10.0));
    for (std::size_t i = 0; i < 2; ++i) links.command(i, 300, 300);
    ASSERT_TRUE(links.wait_acknowledged(10.0));
    for (std::size_t i = 0; i < 2; ++i) robots.silence(i, true);  // the host dies
  };
  const auto stand = [&](std::size_t i) { return robots.wheels(i) == core::WheelSpeeds{}; };
  drive_off();
  for (std::size_t i = 0; i < 2; ++i) robots.silence(i, false);
  ASSERT_TRUE(!stand(0) && !stand(1));
  EXPECT_EQ(stop_robots({"bert"}, path("robots.toml")), done);
  EXPECT_TRUE(!stand(0) && stand(1));
  EXPECT_EQ(stop_robots({}, path("robots.toml")), done);
  EXPECT_TRUE(stand(0));
  EXPECT_EQ(stop_robots({"zoe"}, path("robots.toml")), wrong_input);
  EXPECT_EQ(stop_robots({}, path("nowhere.toml")), wrong_input);
  EXPECT_EQ(list_robots(path("nowhere.toml")), wrong_input);
}

}  // namespace
}  // namespace skein::app
