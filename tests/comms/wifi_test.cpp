// The e-puck2 over WiFi: packets byte for byte, the conversation with the emulated robot, and a real TCP connection.
#include <chrono>
#include <deque>

#include "comms/emulator/tcp_epuck.h"
#include "comms/link_supervisor.h"
#include "comms/wifi_session.h"
#include "tests/comms/bytes.h"
#include "tests/comms/wait_until.h"
#include "tests/property.h"
#include "tests/seconds.h"

namespace skein::comms {
namespace {

using core::WheelSpeeds;
using test::Bytes;
using test::wait_until;

const Bytes the_stop = [] {
  const auto packet = wifi_command({});
  return Bytes(packet.begin(), packet.end());
}();

Bytes sensors(std::int16_t left, std::int16_t right, int battery = 3195) {
  Bytes packet(105, 0xAA);
  packet[0] = 0x02;
  const auto put = [&packet](std::size_t at, int value) {
    packet[1 + at] = static_cast<std::uint8_t>(value & 0xFF);
    packet[2 + at] = static_cast<std::uint8_t>((value >> 8) & 0xFF);
  };
  put(79, left);
  put(81, right);
  put(83, battery);
  return packet;
}

TEST(WifiCodec, ACommandHas21BytesWithLittleEndianSpeeds) {
  const auto packet = wifi_command({.left = 100, .right = -200});
  const Bytes expected{0x80, 0x02, 0x00, 0x64, 0x00, 0x38, 0xFF, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(Bytes(packet.begin(), packet.end()), expected);
}

TEST(WifiCodec, PacketsAreCutWhateverTheChunks) {
  test::holds("sensors, empty packets and pictures come out in order", [] {
    Bytes stream;
    std::vector<std::optional<Encoders>> expected;
    const int count = *rc::gen::inRange(1, 8);
    for (int i = 0; i < count; ++i) {
      const int kind = *rc::gen::inRange(0, 10);
      if (kind == 0) {
        stream.push_back(0x03);
        expected.push_back({});
      } else if (kind == 1) {
        stream.push_back(0x01);
        stream.insert(stream.end(), 38400, 0x02);
        expected.push_back({});
      } else {
        const Encoders counters{*rc::gen::arbitrary<std::int16_t>(), *rc::gen::arbitrary<std::int16_t>()};
        const Bytes packet = sensors(counters.left, counters.right);
        stream.insert(stream.end(), packet.begin(), packet.end());
        expected.push_back(counters);
      }
    }
    WifiParser parser;
    std::size_t found = 0;
    for (std::size_t at = 0; at < stream.size();) {
      const auto size = std::min(stream.size() - at, static_cast<std::size_t>(*rc::gen::inRange(1, 3000)));
      parser.feed(std::span(stream).subspan(at, size));
      at += size;
      while (const auto packet = parser.next()) {
        RC_ASSERT(found < expected.size());
        RC_ASSERT(packet->sensors == expected[found].has_value());
        if (packet->sensors) RC_ASSERT(packet->encoders == *expected[found]);
        ++found;
      }
    }
    RC_ASSERT(found == expected.size());
    RC_ASSERT(parser.pending() == 0u);
  });
}

TEST(WifiCodec, WhatIsNoPacketIsNoticed) {
  WifiParser parser;
  parser.feed(test::bytes("WELCOME"));
  EXPECT_FALSE(parser.next());
  EXPECT_TRUE(parser.garbled());
  parser.clear();
  parser.feed(sensors(1, 2, 3000));
  const auto packet = parser.next();
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->battery, 3000);
}

/// A session and an emulated robot, with the connection between them in the test's hands.
struct WifiLab {
  explicit WifiLab(LinkOptions options = {}) : session(options) {}
  Bytes take() {
    const Bytes out(session.output().begin(), session.output().end());
    session.sent(out.size(), now);
    return out;
  }
  /// One round of the robot's loop: what is written reaches it, and its packet the session.
  void round() {
    Bytes packet;
    robot.receive(take(), packet);
    robot.stream(packet);
    pass(EpuckFirmware::stream_period);
    session.received(packet, now);
  }
  void rounds(int count) {
    for (int k = 0; k < count; ++k) round();
  }
  void pass(double seconds) {
    robot.advance(seconds);
    now += seconds;
    session.advance(now);
  }
  void open() {
    session.opened(now);
    rounds(12);
    ASSERT_TRUE(session.up());
  }
  void command(int left, int right) { session.command(clamped(left, right), ++ticket, now); }

  double now = 1000.0;
  WifiSession session;
  EpuckFirmware robot{core::MotorModel::epuck2, EpuckProgram::wifi};
  std::uint16_t ticket = 0;
};

TEST(WifiSession, StopsFirstAndIsUpWhenTheCountersStand) {
  WifiLab lab;
  lab.session.opened(lab.now);
  EXPECT_EQ(lab.take(), the_stop);
  const auto packet = [&](std::int16_t steps) {
    lab.pass(EpuckFirmware::stream_period);
    (void)lab.take();
    lab.session.received(sensors(steps, steps), lab.now);
  };
  packet(10);
  packet(10);
  EXPECT_FALSE(lab.session.up()) << "these may be older than the stop";
  for (std::int16_t steps = 11; steps < 16; ++steps) {
    packet(steps);
    EXPECT_FALSE(lab.session.stop_acknowledged()) << "it moves on";
  }
  for (int k = 0; k < 4; ++k) packet(15);
  EXPECT_FALSE(lab.session.up()) << "88 ms: at 13 steps/s the next step comes after 77";
  packet(15);
  EXPECT_TRUE(lab.session.up());
  EXPECT_TRUE(lab.session.stop_acknowledged());
}

TEST(WifiSession, DrivesCountsAndReadsTheBattery) {
  WifiLab lab;
  lab.robot.set_battery(3.6);
  lab.open();
  for (int k = 0; k < 50; ++k) {
    lab.command(500, -250);
    lab.rounds(2);
    EXPECT_EQ(lab.robot.wheels(), (WheelSpeeds{500, -250}));
  }
  EXPECT_FALSE(lab.session.stop_acknowledged());
  lab.command(0, 0);
  lab.rounds(3);
  const LinkStatus status = lab.session.status(lab.now);
  EXPECT_NEAR(static_cast<double>(status.left_steps), 50 * 2 * 500 * EpuckFirmware::stream_period, 8);
  EXPECT_NEAR(static_cast<double>(status.right_steps), -50 * 2 * 250 * EpuckFirmware::stream_period, 4);
  EXPECT_GE(status.exchanges, 40u);
  EXPECT_EQ(status.timeouts, 0u);
  EXPECT_NEAR(status.battery.volts, 3.6, 1e-3);
}

TEST(WifiSession, APacketThatNobodyAskedForIsWhatTheRobotDoes) {
  WifiLab lab;
  lab.open();
  lab.rounds(1000);  // 22 s without a command
  EXPECT_TRUE(lab.session.up());
  EXPECT_FALSE(lab.session.garbled());
  EXPECT_EQ(lab.session.status(lab.now).timeouts, 0u);
}

TEST(WifiSession, ARobotThatSomebodyElseDrivesWhileItIsToStandIsStopped) {
  WifiLab lab;
  lab.open();
  lab.rounds(100);
  Bytes none;
  lab.robot.receive(wifi_command({500, 0}), none);  // another host: the firmware listens to ten
  lab.rounds(1);
  ASSERT_EQ(lab.robot.wheels(), (WheelSpeeds{500, 0}));
  lab.rounds(2);
  EXPECT_EQ(lab.robot.wheels(), WheelSpeeds{});
  EXPECT_EQ(lab.session.status(lab.now).reason, "the wheels turned though the robot was stopped");
  lab.rounds(12);
  EXPECT_TRUE(lab.session.up());
  EXPECT_TRUE(lab.session.stop_acknowledged());
  EXPECT_EQ(lab.session.status(lab.now).resynchronisations, 1u);
}

TEST(WifiSession, CommandSilenceIsAStop) {
  WifiLab lab;
  lab.open();
  lab.command(500, 500);
  lab.rounds(4);
  EXPECT_EQ(lab.robot.wheels(), (WheelSpeeds{500, 500}));
  lab.rounds(12);
  EXPECT_EQ(lab.robot.wheels(), WheelSpeeds{});
  EXPECT_TRUE(lab.session.stop_acknowledged());
}

TEST(WifiSession, AStopBehindAPacketThatIsHalfWrittenKeepsThePacketsApart) {
  for (std::size_t written = 0; written <= wifi_command_size; ++written) {
    WifiLab lab;
    lab.open();
    lab.command(500, 500);
    Bytes packet;
    const Bytes begun(lab.session.output().begin(),
                      lab.session.output().begin() + static_cast<std::ptrdiff_t>(written));
    lab.robot.receive(begun, packet);
    lab.session.sent(written, lab.now);
    lab.session.stop(lab.now);
    EXPECT_LE(lab.session.output().size(), 2 * wifi_command_size);
    lab.rounds(14);
    EXPECT_EQ(lab.robot.wheels(), WheelSpeeds{}) << written;
    EXPECT_TRUE(lab.session.stop_acknowledged()) << written;
    EXPECT_TRUE(lab.session.up()) << written;
  }
}

/// The firmware has about ten sockets and never closes one: a robot that pauses keeps its connection.
TEST(WifiSession, APauseOfTheStreamStopsTheRobotAndKeepsTheConnection) {
  WifiLab lab({.command_silence = 0.0});
  lab.open();
  lab.command(400, 400);
  lab.rounds(4);
  for (int k = 0; k < 100; ++k) {  // a second
    lab.pass(0.01);
    (void)lab.take();  // lost in the pause
    EXPECT_FALSE(lab.session.garbled());
  }
  EXPECT_FALSE(lab.session.up());
  EXPECT_GE(lab.session.status(lab.now).blind_stops + lab.session.status(lab.now).timeouts, 1u);
  for (int k = 0; k < 100 && !lab.session.up(); ++k) lab.round();
  EXPECT_TRUE(lab.session.up());
  EXPECT_TRUE(lab.session.stop_acknowledged());
  EXPECT_EQ(lab.robot.wheels(), WheelSpeeds{});
}

/// On the way to the robot everything is lost, on the way back nothing: it drives on by its last command, and its
/// packets come as ever. Only TCP knows that it has not got the newer ones.
TEST(WifiSession, PacketsOfARobotThatHasNotGotItsCommandsConfirmNothing) {
  WifiLab lab;
  lab.open();
  lab.command(700, 700);
  lab.rounds(4);
  ASSERT_EQ(lab.robot.wheels().left, core::actual_step_rate(core::MotorModel::epuck2, 700));
  std::size_t lost = 0;
  const auto lose = [&] {
    lost += lab.take().size();
    Bytes packet;
    lab.robot.stream(packet);
    lab.pass(EpuckFirmware::stream_period);
    lab.session.undelivered(lost);
    lab.session.received(packet, lab.now);
  };
  const double since = lab.now;
  for (int speed = 100; lab.session.up(); ++speed) {
    ASSERT_LT(lab.now, since + 0.7) << "it is taken to obey";
    lab.command(speed, speed);
    lose();
    lose();
  }
  EXPECT_GT(lab.robot.wheels().left, 600);
  for (int k = 0; k < 50; ++k) lose();
  EXPECT_FALSE(lab.session.stop_acknowledged()) << "it drives";
  lab.session.undelivered(0);
  Bytes none;
  lab.robot.receive(the_stop, none);  // TCP sends it again
  lab.rounds(14);
  EXPECT_TRUE(lab.session.up());
  EXPECT_TRUE(lab.session.stop_acknowledged());
}

TEST(WifiSession, OfARobotThatTakesTheConnectionAndSaysNothingTheReasonIsSaid) {
  WifiLab lab;
  lab.session.opened(lab.now);
  const auto say_nothing = [&] {
    for (int k = 0; k < 300; ++k) {
      (void)lab.take();
      lab.pass(0.01);
    }
  };
  say_nothing();
  EXPECT_NE(lab.session.status(lab.now).reason.find("does another program drive the robot?"), std::string::npos)
      << lab.session.status(lab.now).reason;
  for (int k = 0; k < 14; ++k) lab.round();
  ASSERT_TRUE(lab.session.up());
  say_nothing();  // later on: that is something else
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).reason.find("another program"), std::string::npos)
      << lab.session.status(lab.now).reason;
}

TEST(WifiFirmware, OfFiveWaitingCommandsOnlyTheNewestIsCarriedOut) {
  EpuckFirmware robot{core::MotorModel::epuck2, EpuckProgram::wifi};
  Bytes packets;
  for (const int speed : {100, 200, 300, 400}) robot.receive(wifi_command(clamped(speed, speed)), packets);
  robot.stream(packets);
  EXPECT_EQ(robot.wheels(), (WheelSpeeds{100, 100})) << "four: one a round";
  for (const int speed : {500, 600}) robot.receive(wifi_command(clamped(speed, speed)), packets);
  robot.stream(packets);
  EXPECT_NEAR(robot.wheels().left, 600, 10) << "five: the newest";
  EXPECT_EQ(packets.size(), 2 * 105u);
}

TEST(WifiSession, AnyChunksAnyCommandsAnyStopsEndStandingAndUp) {
  test::holds("whatever the order of events, one stop stops the robot", [] {
    WifiLab lab({.command_silence = 0.0});
    lab.session.opened(lab.now);
    std::deque<std::uint8_t> to_robot, to_host;
    const auto carry = [&](std::deque<std::uint8_t>& way, std::size_t most) {
      Bytes chunk;
      for (; !way.empty() && chunk.size() < most; way.pop_front()) chunk.push_back(way.front());
      return chunk;
    };
    const auto step = [&](int what, std::size_t amount) {
      if (what == 0) lab.command(static_cast<int>(amount) * 3 - 300, 200);
      if (what == 1) lab.session.stop(lab.now);
      if (what == 2) lab.pass(0.001 * static_cast<double>(amount));
      if (what == 3) {  // the system takes a part
        const std::size_t taken = std::min(amount, lab.session.output().size());
        to_robot.insert(to_robot.end(), lab.session.output().begin(),
                        lab.session.output().begin() + static_cast<std::ptrdiff_t>(taken));
        lab.session.sent(taken, lab.now);
      }
      if (what == 4) {
        Bytes reply;
        lab.robot.receive(carry(to_robot, amount), reply);
        lab.robot.stream(reply);
        to_host.insert(to_host.end(), reply.begin(), reply.end());
      }
      if (what == 5) lab.session.received(carry(to_host, amount), lab.now);
      if (lab.session.garbled()) {  // connect anew
        lab.session.lost("garbled", lab.now);
        to_robot.clear();
        to_host.clear();
        lab.robot.forget_half_command();
        lab.session.opened(lab.now);
      }
    };
    const auto events = *rc::gen::container<std::vector<std::pair<int, std::size_t>>>(
        rc::gen::pair(rc::gen::inRange(0, 6), rc::gen::inRange<std::size_t>(1, 200)));
    for (const auto& [what, amount] : events) step(what, amount);
    lab.session.stop(lab.now);
    for (int i = 0; i < 500 && !(lab.session.up() && lab.session.stop_acknowledged()); ++i) {
      for (const int what : {3, 4, 5}) step(what, 5000);
      step(2, 10);
    }
    RC_ASSERT(lab.session.up());
    RC_ASSERT(lab.session.stop_acknowledged());
    RC_ASSERT(lab.robot.wheels() == WheelSpeeds{});
  });
}

// --- Over TCP
// ---------------------------------------------------------------------------------------------------------

using test::seconds;

class OverTcp : public testing::Test {
 protected:
  void start(LinkOptions options) {
    links.emplace(std::vector{LinkAddress{LinkKind::tcp, "localhost", robot.port()}}, options);
    const auto started = links->start(10.0);
    ASSERT_TRUE(started) << started.error();
  }
  bool drives(double left, double right) {
    return wait_until([&] { return robot.wheels() == WheelSpeeds{left, right}; });
  }
  bool up() {
    return wait_until([&] { return links->status().at(0).state == LinkState::up; });
  }

  TcpEpuck robot{seconds};
  std::optional<LinkSupervisor> links;
  static constexpr LinkOptions patient{.reply_timeout = 5.0, .command_silence = 0.0, .heartbeat = 0.0};
  static constexpr LinkOptions hasty{.reply_timeout = 0.05,
                                     .command_silence = 0.0,
                                     .heartbeat = 0.05,
                                     .reconnect_first = 0.02,
                                     .reconnect_longest = 0.1};
};

TEST_F(OverTcp, ConnectsDrivesAndStops) {
  start(patient);
  links->command(0, 400, -300);
  EXPECT_TRUE(links->wait_acknowledged(10.0));
  EXPECT_EQ(robot.wheels(), (WheelSpeeds{400, core::actual_step_rate(core::MotorModel::epuck2, -300)}));
  EXPECT_TRUE(links->close(5.0).at(0).stop_acknowledged);
  EXPECT_EQ(robot.wheels(), WheelSpeeds{});
}

TEST_F(OverTcp, ABrokenConnectionIsMadeAnewAndTheRobotStopped) {
  start(hasty);
  links->command(0, 500, 500);
  ASSERT_TRUE(drives(500, 500));
  robot.hang_up();
  EXPECT_TRUE(drives(0, 0)) << "the stop is the first thing on the new connection";
  EXPECT_TRUE(up());
  EXPECT_GE(links->status().at(0).reconnects, 1u);
}

TEST_F(OverTcp, ARobotThatFallsSilentIsStoppedWhenItListensAgain) {
  start(hasty);
  links->command(0, 500, 500);
  ASSERT_TRUE(drives(500, 500));
  robot.silence(true);
  EXPECT_TRUE(wait_until([&] { return links->status().at(0).timeouts > 2; }));
  robot.silence(false);
  EXPECT_TRUE(drives(0, 0));
  EXPECT_TRUE(up());
}

TEST_F(OverTcp, NoiseEndsTheConnectionNotTheLink) {
  start(hasty);
  robot.say({'?', '?'});
  EXPECT_TRUE(wait_until([&] { return links->status().at(0).reconnects >= 1; }));
  EXPECT_TRUE(up());
}

TEST_F(OverTcp, NobodyListeningIsASentence) {
  int port = 0;
  {
    const TcpEpuck gone(seconds);
    port = gone.port();
  }
  LinkSupervisor lonely({{LinkKind::tcp, "127.0.0.1", port}}, {.reconnect_first = 0.02, .close_timeout = 0.1});
  const auto started = lonely.start(2.0);
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().find("selector at 15"), std::string::npos) << started.error();
}

}  // namespace
}  // namespace skein::comms
