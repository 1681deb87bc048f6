// robots.toml: known robots, and experiments that take theirs from it.
#include "app/experiment/known_robots.h"
#include "app/experiment/experiment_robots.h"
#include "app/experiment/file_change.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "app/experiment/toml_edit.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/folder.h"
#include "tests/files.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* robots_text =
    "# our robots\n"
    "[[robot]]\nname = \"anna\"\nlink = \"rfcomm:10:00:e8:aa:bb:cc/1\"\nadapter = \"hci1\"\ntag = 7\nmodel = "
    "\"epuck1\"\nwheel_diameter = 0.0405\n\n"
    "[[robot]]\nname = \"bert\"   # the new one\nlink = \"tcp:192.168.1.20\"\nversion = \"Version 2.0\"\n";

constexpr const char* experiment_text =
    "robots_file = \"robots.toml\"\n"
    "[camera]\nsource = \"v4l2:/dev/video0\"\ncalibration = \"cal.toml\"\n"
    "[[robot]]\nname = \"bert\"\n[[robot]]\nname = \"anna\"\ntrack = 0.054\n";

class KnownRobots : public ::testing::Test {
 protected:
  KnownRobots() {
    write("robots.toml", robots_text);
    write("e.toml", experiment_text);
  }
  std::string path(const std::string& name) const { return (directory / name).string(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name)) << text; }
  std::string message() const {
    const auto e = load_experiment(path("e.toml"));
    return e ? "" : e.error().front().message();
  }

  const test::Folder own_folder;
  const fs::path directory = own_folder.path;
};

TEST_F(KnownRobots, GiveExperimentsWhatTheseDoNotSay) {
  const auto e = load_experiment(path("e.toml"));
  ASSERT_TRUE(e) << e.error().front().message();
  const RobotSpec &bert = e->robots.at(0), &anna = e->robots.at(1);
  EXPECT_EQ(bert.name, "bert");
  EXPECT_EQ(bert.address, "tcp:192.168.1.20");
  EXPECT_EQ(bert.tag, 1) << "the file does not say";
  EXPECT_EQ(anna.address, "rfcomm:10:00:e8:aa:bb:cc/1");
  EXPECT_EQ(anna.adapter, "hci1");
  EXPECT_EQ(anna.tag, 7);
  EXPECT_EQ(anna.motor, core::MotorModel::epuck1);
  EXPECT_EQ(anna.drive.wheel_diameter, 0.0405);
  EXPECT_EQ(anna.drive.track, 0.054) << "the experiment's own keys count more";
  EXPECT_EQ(robot_name(*e, 1), "robot 2 (anna)");
}

TEST_F(KnownRobots, AreInTheTextThatARunKeeps) {
  const auto e = load_experiment(path("e.toml"), {"robot.2.track=0.055"});
  ASSERT_TRUE(e);
  fs::remove(path("robots.toml"));
  const auto again = parse_experiment(e->source, path("e.toml"));
  ASSERT_TRUE(again) << again.error().front().message();
  EXPECT_EQ(again->robots[1].address, e->robots[1].address);
  EXPECT_EQ(again->robots[1].drive.wheel_diameter, 0.0405);
  EXPECT_EQ(again->robots[1].drive.track, 0.055);
  EXPECT_EQ(again->source, e->source);
}

TEST_F(KnownRobots, MistakesAreNamedInTheFileWhereTheyAre) {
  write("robots.toml", std::string(robots_text) + "tag = 7\n");
  EXPECT_EQ(message(),
            path("robots.toml") +
                ":6:7: robot.2.tag: found 7, which robot 1 already has, allowed: a different tag for each robot");
  write("robots.toml", std::string(robots_text) + "wheel = 3\n");
  EXPECT_THAT(message(), HasSubstr(path("robots.toml") + ":14:1: robot.2.wheel: unknown key"));
  write("robots.toml", "[[robot]\n");
  EXPECT_THAT(message(), HasSubstr(path("robots.toml") + ":1:"));
  write("robots.toml", "[[robot]]\nname = \"carl\"\nlink = \"sim\"\n");
  EXPECT_THAT(message(), HasSubstr(path("robots.toml") + ":3:8: robot.1.link: found \"sim\", allowed: the address"));
  write("robots.toml", "[[robot]]\nname = \"carl\"\n");
  EXPECT_THAT(message(), HasSubstr(path("robots.toml") + ":1:1: robot.1.link: missing"));
  write("robots.toml", "[[robot]]\nname = \"anna\"\nlink = \"tcp:a\"\n[[robot]]\nname = \"anna\"\nlink = \"tcp:b\"\n");
  EXPECT_THAT(message(),
              HasSubstr(path("robots.toml") + ":5:8: robot.2.name: found \"anna\", which robot 1 already has"));
  write("robots.toml", "[[robot]]\nname = \"anna\"\nlink = \"tcp:a\"\n");
  EXPECT_EQ(message(), path("e.toml") + ":6:8: robot.1.name: found \"bert\", allowed: a robot of " +
                           path("robots.toml") + ": \"anna\"");
  fs::remove(path("robots.toml"));
  EXPECT_EQ(message(), path("e.toml") + ":1:15: robots_file: " + path("robots.toml") +
                           ": cannot be read: No such file or directory");
}

TEST_F(KnownRobots, AreTakenOnce) {
  write("e.toml", std::string(experiment_text) + "[[robot]]\nname = \"anna\"\n");
  EXPECT_EQ(message(), path("e.toml") +
                           ":11:8: robot.3.name: found \"anna\", which is the name of robot 2, allowed: a different "
                           "name for each robot");
}

bool save(const std::string& file, const std::string& text) {
  auto change = FileChange::begin(file);
  return change && change->save(text);
}

TEST_F(KnownRobots, NewOnesAreAddedBehindAndOldOnesStay) {
  const auto known = load_known_robots(path("robots.toml"));
  ASSERT_TRUE(known);
  KnownRobot anna = known->at(0), carl;
  EXPECT_EQ(anna.spec.address, "rfcomm:10:00:E8:AA:BB:CC/1");
  anna.spec.name = "e-puck_1234";  // as the radio calls it
  carl.spec.name = "e-puck2_04711";
  carl.spec.address = "rfcomm:30:AE:A4:AA:BB:CC/2";
  carl.spec.tag = -1;
  carl.version = "Version \"2\" \\";
  become(carl.spec, *core::find_robot_type("epuck2"));
  const Added added = with_robots(robots_text, *known, {anna, carl});
  EXPECT_EQ(added.robots, 1u);
  EXPECT_TRUE(added.text.starts_with(robots_text));
  const std::string there = path("new/directory/robots.toml");
  ASSERT_TRUE(save(there, added.text));
  const auto again = load_known_robots(there);
  ASSERT_TRUE(again) << again.error().front().message();
  ASSERT_EQ(again->size(), 3u);
  EXPECT_EQ(again->at(2).spec.address, carl.spec.address);
  EXPECT_EQ(again->at(2).spec.tag, -1);
  EXPECT_EQ(again->at(2).version, carl.version);
  EXPECT_FALSE(save("/proc/nowhere/robots.toml", added.text));
}

TEST_F(KnownRobots, ProgramsThatSaveAtTheSameTimeDoNotMixWhatTheyWrite) {
  constexpr std::size_t writers = 4, saves = 20, size = 200'000;
  const std::string file = path("shared.toml");
  const auto text = [](std::size_t writer) {
    return "# " + std::string(size + writer, static_cast<char>('a' + writer)) + "\n";
  };
  std::vector<std::jthread> threads;
  for (std::size_t writer = 0; writer < writers; ++writer)
    threads.emplace_back([&, writer] {
      for (std::size_t k = 0; k < saves; ++k) EXPECT_TRUE(save(file, text(writer)));
    });
  threads.clear();
  const std::string saved = test::read_file(file);
  bool whole = false;
  for (std::size_t writer = 0; writer < writers; ++writer) whole = whole || saved == text(writer);
  EXPECT_TRUE(whole) << saved.size();
  EXPECT_FALSE(fs::exists(file + ".new"));
}

TEST_F(KnownRobots, AChangeThatIsNotSavedLeavesTheFileAndNothingElse) {
  const std::string file = path("robots.toml");
  { ASSERT_TRUE(FileChange::begin(file)); }
  EXPECT_FALSE(fs::exists(file + ".new"));
  EXPECT_TRUE(load_known_robots(file));
}

TEST_F(KnownRobots, AFileBehindALinkIsMadeWhereTheLinkLeads) {
  fs::create_directory(path("shared"));
  fs::create_symlink("shared/robots.toml", path("link.toml"));
  ASSERT_TRUE(save(path("link.toml"), robots_text));
  EXPECT_TRUE(fs::is_symlink(path("link.toml")));
  EXPECT_EQ(test::read_file(path("shared/robots.toml")), robots_text);
  fs::create_symlink("round.toml", path("round.toml"));
  EXPECT_FALSE(save(path("round.toml"), robots_text));
}

/// That of a lab, which its group may change, and one that nobody else may read.
TEST_F(KnownRobots, AFileThatIsSavedAgainHasTheRightsThatItHad) {
  const std::string file = path("robots.toml");
  for (const int mode : {0664, 0600, 0640}) {
    fs::permissions(file, static_cast<fs::perms>(mode));
    ASSERT_TRUE(save(file, robots_text));
    EXPECT_EQ(static_cast<int>(fs::status(file).permissions()), mode);
  }
  if (::geteuid() != 0) return;
  constexpr uid_t anna = 12345;
  ASSERT_EQ(::chown(file.c_str(), anna, anna), 0);
  ASSERT_TRUE(save(file, robots_text));
  struct stat saved {};
  ASSERT_EQ(::stat(file.c_str(), &saved), 0);
  EXPECT_EQ(saved.st_uid, anna) << "sudo skein robots pair --save";
}

TEST_F(KnownRobots, WhatWasMeasuredGoesIntoTheirTables) {
  const auto with =
      with_toml_value(robots_text, "robot.1.wheel_diameter", "0.04123").and_then([](const std::string& text) {
        return with_toml_value(text, "robot.2.tag", "12");
      });
  ASSERT_TRUE(with) << with.error();
  EXPECT_THAT(*with, HasSubstr("wheel_diameter = 0.04123\n\n[[robot]]"));
  EXPECT_THAT(*with, HasSubstr("# the new one"));
  write("robots.toml", *with);
  const auto known = load_known_robots(path("robots.toml"));
  ASSERT_TRUE(known);
  EXPECT_EQ(known->at(0).spec.drive.wheel_diameter, 0.04123);
  EXPECT_EQ(known->at(1).spec.tag, 12);
}

TEST_F(KnownRobots, AreLookedForHereAndThenInTheUsersConfiguration) {
  EXPECT_EQ(known_robots_file("x.toml"), "x.toml");
  const fs::path before = fs::current_path();
  fs::current_path(directory);
  EXPECT_EQ(known_robots_file({}), "robots.toml");
  fs::remove("robots.toml");
  ::setenv("XDG_CONFIG_HOME", "/somewhere", 1);
  EXPECT_EQ(known_robots_file({}), "/somewhere/skein/robots.toml");
  ::unsetenv("XDG_CONFIG_HOME");
  EXPECT_THAT(known_robots_file({}), HasSubstr("/.config/skein/robots.toml"));
  fs::current_path(before);
}

TEST_F(KnownRobots, SevenAnAdapter) {
  std::string text = "reference.speed = 0.02\n[camera]\nsource = \"v4l2:/dev/video0\"\ncalibration = \"c\"\n";
  for (int i = 1; i <= 8; ++i)
    text += "[[robot]]\nlink = \"rfcomm:10:00:E8:00:00:0" + std::to_string(i) + "/1\"\nadapter = \"hci0\"\n";
  EXPECT_THAT(messages(text),
              ElementsAre("e.toml:28:11: robot.8.adapter: found \"hci0\" for more than 7 robots, allowed: "
                          "7 per adapter; use another one for the others, as in adapter = \"hci1\""));
  EXPECT_THAT(messages(text, {"robot.8.adapter=hci1"}), ElementsAre());
  EXPECT_THAT(messages(text, {"robot.8.link=open+rfcomm:10:00:E8:00:00:08/1"}),
              Contains(HasSubstr("robot.8.adapter: found \"hci0\" for more than 7 robots")))
      << "whatever its protocol";
}

TEST_F(KnownRobots, AFileOfRobotsIsNoExperiment) {
  EXPECT_TRUE(is_file_of_robots(path("robots.toml")));
  EXPECT_FALSE(is_file_of_robots(path("e.toml")));
  EXPECT_FALSE(is_file_of_robots(path("nowhere.toml")));
}

}  // namespace
}  // namespace skein::app
