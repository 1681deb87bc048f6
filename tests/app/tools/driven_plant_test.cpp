// What drives real robots without a run keeps the machine awake as a run does. Against a message bus of its own with a
// logind that grants or refuses.
#include "app/tools/driven_plant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <string>
#include <vector>

#include "app/tools/robot_ping.h"
#include "comms/emulator/pty_emulator.h"
#include "core/kinematics/robot_type.h"
#include "tests/comms/fake_logind.h"
#include "tests/eventually.h"

namespace skein::app {
namespace {

using test::eventually;
using test::FakeLogind;
using test::PrivateBus;
using ::testing::Contains;
using ::testing::HasSubstr;

class KeptAwakeWhileToolsDrive : public testing::Test {
 protected:
  void SetUp() override {
    if (!bus.running()) GTEST_SKIP() << "there is no dbus-daemon";
    ::setenv("XDG_STATE_HOME", (testing::TempDir() + "driven-plant-state").c_str(), 1);
  }
  Experiment one_real_robot() const {
    Experiment experiment;
    RobotSpec& robot = experiment.robots.emplace_back();
    robot.link = RobotSpec::Link::device;
    robot.address = "serial:" + robots.device(0);
    robot.type = core::find_robot_type("epuck2");
    return experiment;
  }
  /// Whether it is kept awake while a tool drives the robot.
  bool driven_awake(const FakeLogind& logind, std::vector<std::string>* said = nullptr) {
    const auto driven = DrivenPlant::open(one_real_robot(), {}, [said](const std::string& sentence) {
      if (said) said->push_back(sentence);
    });
    EXPECT_TRUE(driven) << driven.error();
    const bool awake = eventually([&] {
      (*driven)->keep_on();
      return logind.inhibitors() == 1 || (said && !said->empty());
    });
    EXPECT_TRUE((*driven)->close());
    return awake;
  }

  PrivateBus bus;
  comms::PtyEmulator robots{
      {core::MotorModel::epuck2}, nullptr, [] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
      }};
};

TEST_F(KeptAwakeWhileToolsDrive, IsTheMachineUntilTheRobotsStand) {
  const FakeLogind logind(bus);
  EXPECT_TRUE(driven_awake(logind));
  EXPECT_TRUE(eventually([&] { return logind.inhibitors() == 0; }));
}

/// An emulated robot's link is made in the folder for temporary files.
TEST(DrivenPlant, ThatCannotBeOpenedThrowsAndDoesNotCrash) {
  Experiment experiment;
  RobotSpec& robot = experiment.robots.emplace_back();
  robot.link = RobotSpec::Link::loopback;
  robot.type = core::find_robot_type("epuck2");
  const char* const set = std::getenv("TMPDIR");
  const std::string before = set ? set : "";
  ::setenv("TMPDIR", "/nowhere", 1);
  EXPECT_ANY_THROW((void)DrivenPlant::open(experiment, {}, [](const std::string&) {}));
  set ? ::setenv("TMPDIR", before.c_str(), 1) : ::unsetenv("TMPDIR");
}

TEST_F(KeptAwakeWhileToolsDrive, OrTheOperatorIsToldWhyNot) {
  const FakeLogind logind(bus, "Access denied");
  std::vector<std::string> said;
  EXPECT_TRUE(driven_awake(logind, &said));
  EXPECT_THAT(said, Contains(HasSubstr("may suspend while robots drive: Access denied")));
}

TEST_F(KeptAwakeWhileToolsDrive, AShutdownStopsTheRobotAndWaitsForThat) {
  FakeLogind logind(bus);
  const auto driven = DrivenPlant::open(one_real_robot(), {}, [](const std::string&) {});
  ASSERT_TRUE(driven) << driven.error();
  ASSERT_TRUE(eventually([&] { return logind.delays() == 1; }));
  const auto drives = [&] { return robots.wheels(0).left > 0.0; };
  ASSERT_TRUE(eventually([&] {
    (*driven)->plant().act(std::array{core::WheelSpeeds{300, 300}});
    return drives();
  }));
  robots.silence(0, true);  // it hears no stop for the time being
  logind.announce("PrepareForShutdown", true);
  ASSERT_TRUE(eventually([&] { return !(*driven)->keep_on(); }));
  EXPECT_FALSE(eventually([&] { return logind.delays() == 0; }, std::chrono::seconds(1))) << "the robot drives";
  robots.silence(0, false);
  EXPECT_TRUE(eventually([&] { return logind.delays() == 0; }));
  EXPECT_FALSE(drives()) << "the machine is switched off while the robot drives";
  EXPECT_TRUE((*driven)->close());
}

TEST_F(KeptAwakeWhileToolsDrive, AlsoByAPing) {
  const FakeLogind logind(bus);
  int most = 0;
  PingOptions options;
  options.keep_on = [&] { return (most = std::max(most, logind.inhibitors())) == 0; };
  const auto ping = ping_robots(one_real_robot(), options);
  ASSERT_TRUE(ping) << ping.error();
  EXPECT_EQ(most, 1);
  EXPECT_TRUE(eventually([&] { return logind.inhibitors() == 0; }));
}

}  // namespace
}  // namespace skein::app
