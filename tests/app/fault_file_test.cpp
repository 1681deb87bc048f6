#include "app/experiment/fault_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>

#include "app/commands/command_line.h"
#include "app/commands/commands.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/transport.h"

namespace skein::app {
namespace {

using comms::FaultKind;

/// What is wrong with the text, one message a line.
std::string refusals(std::string_view text) {
  const auto faults = parse_faults(text, "faults.toml", 4);
  std::string all;
  if (!faults)
    for (const Problem& problem : faults.error()) all += problem.message() + "\n";
  return all;
}

TEST(FaultFile, ReadsFaultsWithTheirAmounts) {
  const auto faults = parse_faults(R"([[fault]]
kind = "latency"
robot = 2
at = 10
for = 5.5
median = 0.02
p99 = 0.1
[[fault]]
kind = "loss"
share = 0.1
[[fault]]
kind = "battery"
volts = 3.6
sag = 0.05
[[fault]]
kind = "stuck"
at = 3
)",
                                   "faults.toml", 4);
  ASSERT_TRUE(faults) << faults.error().front().message();
  ASSERT_EQ(faults->size(), 4u);
  const comms::Fault& latency = (*faults)[0];
  EXPECT_EQ(latency.kind, FaultKind::latency);
  EXPECT_EQ(latency.robot, 1u) << "counted from 0 in code";
  EXPECT_EQ(latency.at, 10.0);
  EXPECT_EQ(latency.duration, 5.5);
  EXPECT_EQ(latency.p99, 0.1);
  EXPECT_FALSE((*faults)[1].robot) << "every robot";
  EXPECT_TRUE(std::isinf((*faults)[1].duration)) << "to the end";
  EXPECT_EQ((*faults)[2].volts, 3.6);
  EXPECT_EQ((*faults)[3].duration, 0.0) << "an instant";
}

TEST(FaultFile, EveryKindHasItsWord) {
  for (const char* const kind : {"burst", "disconnect", "reboot", "ring", "swapped_wheels", "silent_encoders"}) {
    const auto faults = parse_faults(std::string("[[fault]]\nkind = \"") + kind + "\"\n", "faults.toml", 1);
    ASSERT_TRUE(faults) << kind;
    EXPECT_EQ(comms::to_text(faults->at(0).kind), kind);
  }
}

TEST(FaultFile, RefusesWhatIsWrongWithItsPlace) {
  const auto refuses = [](std::string_view text, std::string_view what) {
    const std::string messages = refusals(text);
    EXPECT_NE(messages.find(what), std::string::npos) << text << "\n" << messages;
  };
  refuses("[[fault]]\nkind = \"loss\"\nshare = 2\n", "faults.toml:3:9: fault.1.share: found 2");
  refuses("[[fault]]\nkind = \"lost\"\n", "faults.toml:2:8: fault.1.kind: found \"lost\"");
  refuses("[[fault]]\nkind = \"burst\"\nshare = 0.5\n", "faults.toml:3:1: fault.1.share: unknown key");
  refuses("[[fault]]\nkind = \"burst\"\nrobot = 5\n", "faults.toml:3:9: fault.1.robot: found 5");
  refuses("[[fault]]\nkind = \"burst\"\nfoor = 5\n", "did you mean for?");
  refuses("[[fault]]\nkind = \"latency\"\n", "fault.1.median: missing");
  refuses("[[fault]]\nkind = \"latency\"\nmedian = 0.1\np99 = 0.05\n", "faults.toml:4:7: fault.1.p99: found 0.05");
  refuses("[[fault]]\nat = 1\n", "fault.1.kind: missing");
  refuses("[[faults]]\nkind = \"burst\"\n", "faults.toml:1:");
  refuses("kind = \n", "faults.toml:1:");
}

TEST(FaultFile, AFileThatIsNotThereIsAProblem) {
  const auto faults = load_faults("/nowhere/faults.toml", 1);
  ASSERT_FALSE(faults);
  EXPECT_NE(faults.error().at(0).message().find("/nowhere/faults.toml: cannot be read"), std::string::npos);
}

// --- skein robots stop
// ------------------------------------------------------------------------------------------------

double seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

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
  EXPECT_EQ(stop_robots({std::string(SKEIN_SOURCE_DIR) + "/resources/experiments/platoon.toml"}), wrong_input)
      << "nobody in it is real";
}

}  // namespace
}  // namespace skein::app
