#include "comms/robot_check.h"

#include <chrono>

#include "comms/emulator/pty_emulator.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using core::MotorModel;

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

RobotCheck check(MotorModel model, std::vector<Fault> faults) {
  const PtyEmulator robots({model}, nullptr, seconds, {}, faults);
  const auto checked = check_robot({LinkKind::serial, robots.device(0), 0, {}, {}}, 10.0);
  EXPECT_TRUE(checked) << checked.error();
  EXPECT_EQ(robots.wheels(0), core::WheelSpeeds{});
  return checked.value_or(RobotCheck{});
}

TEST(RobotCheck, AHealthyRobotSaysWhoItIsAndTurnsItsWheels) {
  const RobotCheck robot = check(MotorModel::epuck2, {});
  EXPECT_EQ(robot.version, "Version 2.0 January 2018 GCtronic");
  EXPECT_NEAR(robot.battery.volts, 3.9, 1e-3);
  EXPECT_FALSE(robot.battery.low);
  EXPECT_GE(robot.left_steps, 20);
  EXPECT_GE(robot.right_steps, 20);
  EXPECT_TRUE(robot.faults.empty()) << robot.faults.front();
}

TEST(RobotCheck, NamesSwappedWheels) {
  const RobotCheck robot = check(MotorModel::epuck1, {{.kind = FaultKind::swapped_wheels}});
  ASSERT_EQ(robot.faults.size(), 2u);
  EXPECT_NE(robot.faults[0].find("swapped"), std::string::npos) << robot.faults[0];
}

TEST(RobotCheck, NamesSilentEncoders) {
  const RobotCheck robot = check(MotorModel::epuck2, {{.kind = FaultKind::silent_encoders}});
  ASSERT_EQ(robot.faults.size(), 2u);
  EXPECT_NE(robot.faults[0].find("left wheel's encoder is silent"), std::string::npos) << robot.faults[0];
  EXPECT_NE(robot.faults[1].find("right wheel's encoder is silent"), std::string::npos) << robot.faults[1];
}

TEST(RobotCheck, ARobotThatCannotBeReachedIsASentence) {
  const auto checked = check_robot({LinkKind::serial, "/nowhere", 0, {}, {}}, 1.0);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error(), "there is no device /nowhere");
}

}  // namespace
}  // namespace skein::comms
