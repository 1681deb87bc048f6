#include "comms/emulator/emulated_epuck.h"

#include <limits>

#include "comms/asercom.h"
#include "comms/epuck_wifi.h"
#include "tests/comms/bytes.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using core::MotorModel;
using test::Bytes;
using test::bytes;

/// What the host has heard by `now` after writing `request` then.
Bytes ask_at(EmulatedEpuck& robot, std::span<const std::uint8_t> request, double now) {
  robot.receive(request, now);
  return robot.take();
}
Bytes ask_at(EmulatedEpuck& robot, std::string_view request, double now) {
  return ask_at(robot, bytes(request), now);
}
Bytes heard_at(EmulatedEpuck& robot, double now) {
  robot.advance(now);
  return robot.take();
}

EmulatedEpuck with(Fault fault, MotorModel model = MotorModel::epuck2) {
  return EmulatedEpuck(model, 100.0, {fault}, 7);
}

TEST(EmulatedEpuck, WithoutFaultsAnswersAtOnceByteForByte) {
  test::holds("the firmware alone", [](const std::vector<std::vector<std::uint8_t>>& writes) {
    EmulatedEpuck robot(MotorModel::epuck1, 0.0);
    EpuckFirmware firmware(MotorModel::epuck1);
    double now = 0.0;
    for (const auto& write : writes) {
      now += 0.25;
      firmware.advance(0.25);
      RC_ASSERT(ask_at(robot, write, now) == test::ask(firmware, write));
      RC_ASSERT(robot.deadline() == std::numeric_limits<double>::infinity());
      RC_ASSERT(robot.wheels() == firmware.wheels());
    }
  });
}

TEST(EmulatedEpuck, AnswersComeLaterAndInOrder) {
  EmulatedEpuck robot = with({.kind = FaultKind::latency, .median = 0.1, .p99 = 0.1});
  EXPECT_TRUE(ask_at(robot, "D,100,100\nE\n", 100.0).empty());
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{}) << "half of it on the way there";
  EXPECT_NEAR(robot.deadline(), 100.05, 1e-9);
  EXPECT_TRUE(heard_at(robot, 100.06).empty());
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100}));
  EXPECT_NEAR(robot.deadline(), 100.1, 1e-9);
  EXPECT_EQ(test::text(heard_at(robot, 100.11)), "d\r\ne,100,100\r\n");
}

TEST(EmulatedEpuck, LatenciesHaveTheirMedianAndTheir99thPercentile) {
  EmulatedEpuck robot = with({.kind = FaultKind::latency, .median = 0.02, .p99 = 0.1});
  int below_median = 0, above_p99 = 0;
  double now = 100.0;
  for (int i = 0; i < 4000; ++i) {
    now += 10.0;
    robot.receive(Bytes{0xAF, 0x00}, now);
    const double way = robot.deadline() - now;
    below_median += way < 0.01 ? 1 : 0;
    above_p99 += way > 0.05 ? 1 : 0;
    (void)heard_at(robot, now + 9.0);
  }
  EXPECT_NEAR(below_median, 2000, 150);
  EXPECT_NEAR(above_p99, 40, 25);
}

TEST(EmulatedEpuck, AShareOfTheMessagesIsLost) {
  EmulatedEpuck robot = with({.kind = FaultKind::loss, .share = 0.2});
  int answered = 0;
  for (int i = 0; i < 2000; ++i) answered += ask_at(robot, Bytes{0xAF, 0x00}, 100.0 + i).empty() ? 0 : 1;
  EXPECT_NEAR(answered, 2000 * 0.8 * 0.8, 80) << "there and back";
}

TEST(EmulatedEpuck, ABurstTakesEverythingAndEnds) {
  EmulatedEpuck robot = with({.kind = FaultKind::burst, .at = 1.0, .duration = 2.0});
  EXPECT_EQ(ask_at(robot, "D,100,100\n", 100.5).size(), 3u);
  EXPECT_FALSE((robot.advance(101.5), robot.carries()));
  EXPECT_TRUE(ask_at(robot, stop_sequence(), 102.0).empty());
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100}));
  EXPECT_EQ(test::text(ask_at(robot, stop_sequence(), 103.0)), "s\r\n");
  EXPECT_TRUE(robot.carries());
}

// TCP sends again what was lost, after 0.2 s, 0.6 s, 1.4 s, 3 s ...; none comes as another or overtakes another.
TEST(EmulatedEpuck, OverTcpWhatIsLostComesLaterAndInOrder) {
  const auto over_tcp = [](std::vector<Fault> faults) {
    return EmulatedEpuck(MotorModel::epuck2, 100.0, std::move(faults), 7, EpuckProgram::wifi);
  };
  EmulatedEpuck robot = over_tcp({{.kind = FaultKind::burst, .at = 1.0, .duration = 1.0}});
  robot.receive(wifi_command({100, 100}), 100.5);
  robot.advance(101.1);
  ASSERT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100}));
  robot.receive(wifi_command({200, 200}), 101.1);
  robot.receive(wifi_command({0, 0}), 101.95);
  robot.advance(102.2);
  (void)robot.take();
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100})) << "the burst is over";
  EXPECT_FALSE(robot.carries()) << "what is sent now waits behind what is sent again";
  EXPECT_TRUE(robot.answers_late());
  robot.advance(102.5 + EpuckFirmware::stream_period);
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{200, 200})) << "1.4 s after it was first sent";
  robot.advance(102.5 + 3.0 * EpuckFirmware::stream_period);
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});

  EmulatedEpuck noisy =
      over_tcp({{.kind = FaultKind::corruption, .at = 1.0, .duration = 2.0, .share = 0.02}, {.kind = FaultKind::ring}});
  WifiParser parser;
  std::size_t packets = 0;
  for (int k = 0; k < 500; ++k) {
    const double now = 100.0 + 0.022 * k;
    noisy.receive(wifi_command({100, -100}), now);
    parser.feed(noisy.take());
    while (parser.next()) ++packets;
    ASSERT_FALSE(parser.garbled());
    ASSERT_TRUE(noisy.wheels() == core::WheelSpeeds{} || noisy.wheels() == (core::WheelSpeeds{100, -100}));
  }
  EXPECT_NEAR(static_cast<double>(packets), 500.0, 5.0) << "none is missing in the end";
}

TEST(EmulatedEpuck, CorruptedBytesAreOtherBytesAndNoneIsMissing) {
  EmulatedEpuck robot = with({.kind = FaultKind::corruption, .at = 1.0, .share = 1.0});
  ask_at(robot, Bytes{}, 100.5);
  const Bytes clean = ask_at(robot, Bytes{0xAF, 0x00}, 100.9);
  EXPECT_EQ(clean, (Bytes{0, 0, 0, 0}));
  for (int i = 0; i < 50; ++i)
    for (const std::uint8_t byte : ask_at(robot, "\n", 102.0 + i)) EXPECT_NE(byte, 's');
}

TEST(EmulatedEpuck, ABrokenConnectionLosesWhatIsInTheAirAndLeavesTheWheelsRunning) {
  EmulatedEpuck robot(MotorModel::epuck2, 0.0,
                      {{.kind = FaultKind::latency, .median = 0.1, .p99 = 0.1},
                       {.kind = FaultKind::disconnect, .at = 1.0, .duration = 2.0}});
  robot.receive(bytes("D,100,100\n"), 0.5);
  robot.receive(bytes("D,200,200\n"), 0.99);
  robot.advance(1.5);
  EXPECT_FALSE(robot.connected());
  EXPECT_EQ(robot.breaks(), 1u);
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100}));
  robot.receive(bytes("D,300,300\n"), 2.0);
  robot.advance(3.5);
  EXPECT_TRUE(robot.connected());
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100}));
}

TEST(EmulatedEpuck, ARobotThatIsOffStandsAndGreetsWhenItIsBack) {
  EmulatedEpuck robot = with({.kind = FaultKind::reboot, .at = 1.0, .duration = 0.5}, MotorModel::epuck1);
  ask_at(robot, "D,100,100\n", 100.5);
  EXPECT_TRUE(ask_at(robot, "D,100,100\n", 101.2).empty());
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
  EXPECT_EQ(test::text(heard_at(robot, 101.5)), EpuckFirmware(MotorModel::epuck1).greeting());
}

TEST(EmulatedEpuck, AStuckParserIsFreedByTheStopSequence) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    EmulatedEpuck robot(MotorModel::epuck2, 0.0, {{.kind = FaultKind::stuck, .at = 1.0, .duration = 0.0}}, seed);
    ask_at(robot, "D,100,100\n", 0.5);
    ask_at(robot, test::set_and_read({5, 5}), 1.5);
    const std::string answer = test::text(ask_at(robot, stop_sequence(), 2.0));
    EXPECT_TRUE(answer.ends_with("s\r\n")) << answer;
    EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
  }
}

/// 64 places and two counters: byte 64 is stored, and read, in the place of byte 0 as well as in its own.
TEST(EmulatedEpuck, ABurstOverwritesTheBeginningOfTheRing) {
  EmulatedEpuck robot = with({.kind = FaultKind::ring}, MotorModel::epuck1);
  const Bytes stop(stop_sequence().begin(), stop_sequence().end());
  EXPECT_TRUE(ask_at(robot, stop, 101.0).empty()) << "43 bytes take 3.7 ms";
  EXPECT_EQ(test::text(heard_at(robot, 101.004)), "s\r\n");
  Bytes lines = bytes("D,100,100\n");
  lines.resize(60, '\n');
  const Bytes end = bytes("\nQ\nE\n");
  lines.insert(lines.end(), end.begin(), end.end());
  robot.receive(lines, 102.0);
  EXPECT_EQ(test::text(heard_at(robot, 102.1)), "z,Command not found\r\nq,0,0\r\ne,0,0\r\n")
      << "the line end of byte 64 where the D was";
  // Two writes without a pause are one burst; the end of a stop is never lost.
  robot.receive(stop, 103.0);
  robot.receive(stop, 103.001);
  EXPECT_TRUE(test::text(heard_at(robot, 103.1)).ends_with("s\r\n"));
  // An exchange and a stop fit.
  robot.receive(test::set_and_read({100, 100}), 104.0);
  robot.receive(stop, 104.0);
  EXPECT_EQ(heard_at(robot, 104.1).size(), 4u + 3u);
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
}

TEST(EmulatedEpuck, TheBatterySags) {
  EmulatedEpuck robot = with({.kind = FaultKind::battery, .volts = 4.2, .sag = 0.2});
  EXPECT_EQ(test::text(ask_at(robot, "b\n", 100.0)), "b,3441 (100%)\r\n");
  EXPECT_EQ(test::text(ask_at(robot, "b\n", 220.0)), "b,3113 (50%)\r\n");
  EmulatedEpuck old = with({.kind = FaultKind::battery, .volts = 3.5, .sag = 0.2}, MotorModel::epuck1);
  EXPECT_EQ(test::text(ask_at(old, "b\n", 100.0)), "b,1\r\n");
  EXPECT_EQ(test::text(ask_at(old, "b\n", 160.0)), "b,0\r\n");
}

TEST(EmulatedEpuck, SwappedWheelsAndSilentEncoders) {
  EmulatedEpuck swapped = with({.kind = FaultKind::swapped_wheels});
  ask_at(swapped, "D,100,-200\n", 100.0);
  EXPECT_EQ(swapped.wheels(), (core::WheelSpeeds{-200, 100}));
  EXPECT_EQ(test::text(ask_at(swapped, "Q\n", 101.0)), "q,-198,99\r\n");
  EmulatedEpuck silent = with({.kind = FaultKind::silent_encoders});
  ask_at(silent, "D,100,-200\n", 100.0);
  EXPECT_EQ(test::text(ask_at(silent, "Q\n", 101.0)), "q,0,0\r\n");
}

TEST(RandomFaults, AreOfEveryKindWithinTheTimeAndTheSameForTheSameSeed) {
  const auto faults = random_faults(4, 600.0, 3.0, 42), again = random_faults(4, 600.0, 3.0, 42);
  ASSERT_EQ(faults.size(), again.size());
  EXPECT_NEAR(static_cast<double>(faults.size()), 4 * 200.0, 120.0);
  std::vector<int> counts(12);
  for (std::size_t i = 0; i < faults.size(); ++i) {
    EXPECT_EQ(faults[i].at, again[i].at);
    EXPECT_EQ(faults[i].kind, again[i].kind);
    EXPECT_GE(faults[i].at, 0.0);
    EXPECT_LE(faults[i].end(), 600.0 + 1e-9);
    ++counts.at(static_cast<std::size_t>(faults[i].kind));
    EXPECT_FALSE(word(faults[i].kind).empty());
  }
  for (const int count : counts) EXPECT_GT(count, 0);
  EXPECT_NE(random_faults(4, 600.0, 3.0, 43).front().at, faults.front().at);
}

TEST(RandomFaults, AfterAnyOfThemOneResynchronisationStopsTheRobot) {
  test::holds("whatever was written, whatever failed",
              [](std::uint64_t seed, const std::vector<std::vector<std::uint8_t>>& writes) {
                EmulatedEpuck robot(seed % 2 == 0 ? MotorModel::epuck1 : MotorModel::epuck2, 0.0,
                                    faults_of(random_faults(1, 2.0, 0.2, seed), 0), seed);
                double now = 0.0;
                for (const auto& write : writes) ask_at(robot, write, now += 0.02);
                (void)heard_at(robot, std::max(now, 2.0) + 1.0);
                const std::string answer = test::text(ask_at(robot, stop_sequence(), std::max(now, 2.0) + 2.0));
                RC_ASSERT(answer.ends_with("s\r\n"));
                RC_ASSERT(robot.wheels() == core::WheelSpeeds{});
              });
}

}  // namespace
}  // namespace skein::comms
