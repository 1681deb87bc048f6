// skein robots stop
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>

#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/transport.h"
#include "tests/places.h"
#include "tests/seconds.h"

namespace skein::app {
namespace {

using test::seconds;

TEST(RobotsStop, StopsWhateverStateTheyWereLeftIn) {
  comms::PtyEmulator robots({core::MotorModel::epuck1, core::MotorModel::epuck2}, nullptr, seconds);
  const std::string first = "serial:" + robots.device(0), second = "serial:" + robots.device(1);
  {
    auto line = comms::Transport::open({comms::LinkKind::serial, robots.device(0), 0, {}, {}});
    ASSERT_TRUE(line);
    const std::string left_behind = "D,500,500\nD,0";
    ASSERT_TRUE(line->write(std::span(reinterpret_cast<const std::uint8_t*>(left_behind.data()), left_behind.size())));
    for (int i = 0; i < 10000 && robots.wheels(0) == core::WheelSpeeds{}; ++i) ::usleep(1000);
  }
  EXPECT_EQ(robots.wheels(0), (core::WheelSpeeds{500, 500}));
  EXPECT_EQ(stop_robots({first, second}), done);
  EXPECT_EQ(robots.wheels(0), core::WheelSpeeds{});
}

TEST(RobotsStop, ARobotThatIsNotThereIsStatusThreeAndTheOthersStop) {
  comms::PtyEmulator robots({core::MotorModel::epuck2}, nullptr, seconds);
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  EXPECT_EQ(stop_robots({"serial:/nowhere", "serial:" + robots.device(0)}), device_failed);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "serial:" + robots.device(0) + ": stopped\n");
  EXPECT_NE(testing::internal::GetCapturedStderr().find("serial:/nowhere: NOT known to be stopped"), std::string::npos);
}

TEST(RobotsStop, WrongWordsAreRefused) {
  EXPECT_EQ(stop_robots({"bluetooth"}), wrong_input);
  EXPECT_EQ(stop_robots({"/nowhere.toml"}), wrong_input);
  EXPECT_EQ(stop_robots({test::in_source("resources/experiments/platoon.toml")}), wrong_input)
      << "nobody in it is real";
}

}  // namespace
}  // namespace skein::app
