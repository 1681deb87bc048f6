#include "app/experiment/fault_file.h"

#include <gtest/gtest.h>

#include <cmath>

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
    EXPECT_EQ(word(faults->at(0).kind), kind);
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

}  // namespace
}  // namespace skein::app
