// The open protocol: the codec against bytes worked out by hand, the session against the reference robot in C, over
// datagrams that the kernel carries, and what happens when the commander dies.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>

#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "comms/emulator/emulated_epuck.h"
#include "comms/emulator/emulator_loop.h"
#include "comms/emulator/make_firmware.h"
#include "comms/link_supervisor.h"
#include "comms/open_session.h"
#include "comms/protocol.h"
#include "comms/watchdog.h"
#include "core/simulation/random.h"
#include "resources/robots/open_robot/open_robot.h"
#include "tests/comms/bytes.h"
#include "tests/comms/radio_faults.h"
#include "tests/comms/wait_until.h"
#include "tests/fuzz/open_targets.h"
#include "tests/seconds.h"

namespace skein::comms {
namespace {

using core::WheelSpeeds;
using test::Bytes;

const core::RobotType& open_type() {
  return *core::find_robot_type("open");
}

using test::seconds;

Bytes ask_open(OpenFirmware& robot, std::span<const std::uint8_t> request) {
  Bytes reply;
  robot.receive(request, reply);
  return reply;
}

OpenStatus status_in(const Bytes& reply) {
  OpenParser parser;
  parser.feed(reply);
  const auto frame = parser.next();
  if (!frame) return {};
  return open_status(*frame).value_or(OpenStatus{});
}

Bytes wheels(std::uint16_t number, std::int16_t left, std::int16_t right) {
  const auto l = static_cast<std::uint16_t>(left), r = static_cast<std::uint16_t>(right);
  return open_frame('W', number,
                    std::array{static_cast<std::uint8_t>(l & 255), static_cast<std::uint8_t>(l >> 8),
                               static_cast<std::uint8_t>(r & 255), static_cast<std::uint8_t>(r >> 8)});
}

TEST(OpenCodec, FramesAreTheDocumentsBytes) {
  // docs/open-protocol.md shows these; the check sums are those of Python's binascii.crc_hqx(frame[2:-2], 0xFFFF).
  EXPECT_EQ(open_frame('X', 1), (Bytes{0x53, 0x6B, 0x01, 0x58, 0x01, 0x00, 0x00, 0x95, 0x7C}));
  EXPECT_EQ(wheels(2, 1000, -500),
            (Bytes{0x53, 0x6B, 0x01, 0x57, 0x02, 0x00, 0x04, 0xE8, 0x03, 0x0C, 0xFE, 0x0D, 0x05}));
  const Bytes check = test::bytes("123456789");
  EXPECT_EQ(open_robot_crc(check.data(), check.size()), 0x29B1) << "the catalogue's check value";
}

TEST(OpenRobot, ObeysOnlyAfterAStopAndNothingOlderThanWhatItObeyed) {
  OpenFirmware robot(open_type());
  EXPECT_TRUE(status_in(ask_open(robot, wheels(5, 100, 100))).refused);
  EXPECT_EQ(robot.told(), WheelSpeeds{});
  EXPECT_FALSE(status_in(ask_open(robot, open_frame('X', 10))).booted);
  EXPECT_EQ(status_in(ask_open(robot, wheels(11, 300, -200))).taken, (WheelCommand{300, -200}));
  EXPECT_TRUE(status_in(ask_open(robot, wheels(11, 900, 900))).refused) << "the same number again";
  EXPECT_TRUE(status_in(ask_open(robot, wheels(9, 900, 900))).refused) << "a datagram that was overtaken";
  EXPECT_EQ(robot.told(), (WheelSpeeds{300, -200}));
  EXPECT_FALSE(status_in(ask_open(robot, open_frame('X', 65535))).refused);
  EXPECT_EQ(status_in(ask_open(robot, wheels(0, 10, 10))).taken, (WheelCommand{10, 10})) << "numbers wrap around";
}

TEST(OpenRobot, ItsWatchdogStopsIt200msAfterTheLastSpeeds) {
  OpenFirmware robot(open_type());
  ask_open(robot, open_frame('X', 1));
  ask_open(robot, wheels(2, 1000, 1000));
  robot.advance(0.15);
  ask_open(robot, wheels(3, 1000, 1000));
  robot.advance(0.19);
  EXPECT_EQ(robot.told(), (WheelSpeeds{1000, 1000}));
  robot.advance(0.0111);
  EXPECT_EQ(robot.told(), WheelSpeeds{});
  const OpenStatus said = status_in(ask_open(robot, open_frame('Q', 4)));
  EXPECT_TRUE(said.timed_out);
  EXPECT_NEAR(said.encoders.left, 350, 2) << "it stood as soon as that, however late anybody looked";
  robot.advance(10.0);
  EXPECT_NEAR(status_in(ask_open(robot, open_frame('Q', 5))).encoders.left, 350, 2);
  ask_open(robot, wheels(6, 1000, 1000));
  EXPECT_EQ(robot.told(), (WheelSpeeds{1000, 1000})) << "and goes on with the next command";
}

TEST(OpenRobot, ATwistIsTwoWheels) {
  OpenFirmware robot(open_type());  // 0.1 m between the wheels
  ask_open(robot, open_frame('X', 1));
  // 0.1 m/s, 1 rad/s: 0.05 m/s and 0.15 m/s.
  ask_open(robot, open_frame('T', 2, Bytes{0xE8, 0x03, 0xE8, 0x03}));
  EXPECT_EQ(robot.told(), (WheelSpeeds{500, 1500}));
  ask_open(robot, wheels(3, 32767, -32768));
  EXPECT_EQ(robot.told(), (WheelSpeeds{5000, -5000})) << "no faster than it can";
}

TEST(OpenRobot, AStopIsObeyedInAnyVersionAndOthersAreToldWhichItSpeaks) {
  OpenFirmware robot(open_type());
  ask_open(robot, open_frame('X', 1));
  ask_open(robot, wheels(2, 500, 500));
  const auto of_version_2 = [](Bytes frame) {
    frame[2] = 2;
    const std::uint16_t sum = open_robot_crc(frame.data() + 2, frame.size() - 4);
    frame[frame.size() - 2] = static_cast<std::uint8_t>(sum & 255);
    frame[frame.size() - 1] = static_cast<std::uint8_t>(sum >> 8);
    return frame;
  };
  OpenParser parser;
  parser.feed(ask_open(robot, of_version_2(wheels(3, 900, 900))));
  const auto name = parser.next();
  ASSERT_TRUE(name);
  EXPECT_EQ(name->kind, 'h');
  EXPECT_EQ(std::string(name->payload.begin() + 6, name->payload.end()), "emulated");
  EXPECT_EQ(robot.told(), (WheelSpeeds{500, 500}));
  ask_open(robot, of_version_2(open_frame('X', 4)));
  EXPECT_EQ(robot.told(), WheelSpeeds{});
}

TEST(OpenRobot, AStopIsUnderstoodBehindAnyFrameThatWasBrokenOff) {
  const Bytes frame = wheels(2, 1000, 1000);
  for (std::size_t cut = 0; cut < frame.size(); ++cut) {
    OpenFirmware robot(open_type());
    ask_open(robot, open_frame('X', 1));
    ask_open(robot, std::span(frame).first(cut));
    EXPECT_TRUE(open_acknowledged(ask_open(robot, open_stop()))) << cut;
    EXPECT_EQ(robot.told(), WheelSpeeds{});
  }
}

/// A session and the robot, with the connection in the test's hands.
struct OpenLab {
  explicit OpenLab(LinkOptions options = {}) : session(options) {}
  Bytes take() {
    const Bytes out(session.output().begin(), session.output().end());
    session.sent(out.size(), now);
    return out;
  }
  void exchange() {
    for (int k = 0; k < 8 && !session.output().empty(); ++k) session.received(ask_open(robot, take()), now);
  }
  void pass(double dt) {
    robot.advance(dt);
    now += dt;
    session.advance(now);
  }
  void command(int left, int right) {
    session.command({static_cast<std::int16_t>(left), static_cast<std::int16_t>(right)}, ++ticket, now);
  }
  void open() {
    session.opened(now);
    exchange();
    ASSERT_TRUE(session.up());
  }
  double now = 100.0;
  OpenSession session;
  OpenFirmware robot{open_type()};
  std::uint16_t ticket = 0;
};

TEST(OpenSession, DrivesReadsAndKeepsTheWatchdogFed) {
  OpenLab lab({.battery_period = 1.0, .ask_version = true});
  lab.open();
  for (int tick = 0; tick < 100; ++tick) {
    lab.command(1000, 500);
    lab.exchange();
    lab.pass(0.04);
  }
  EXPECT_EQ(lab.robot.told(), (WheelSpeeds{1000, 500}));
  const LinkStatus status = lab.session.status(lab.now);
  EXPECT_NEAR(static_cast<double>(status.left_steps), 3960, 50);
  EXPECT_NEAR(static_cast<double>(status.right_steps), 1980, 50);
  EXPECT_NEAR(status.battery.volts, 7.4, 1e-9);
  EXPECT_EQ(status.version, "emulated, open protocol");
  EXPECT_EQ(status.timeouts, 0u);
}

TEST(OpenSession, ALostDatagramCostsNothing) {
  OpenLab lab;
  lab.open();
  core::Random random(7, 0);
  int lost = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    lab.command(1000 + tick % 7, 1000);
    while (!lab.session.output().empty()) {
      const Bytes request = lab.take();
      const bool there = random.uniform() < 0.9, back = random.uniform() < 0.9;
      lost += !there || !back;
      if (!there) continue;
      const Bytes reply = ask_open(lab.robot, request);
      if (back) lab.session.received(reply, lab.now);
    }
    lab.pass(0.04);
    ASSERT_TRUE(lab.session.up()) << lab.session.status(lab.now).reason;
  }
  EXPECT_GT(lost, 200);
  EXPECT_EQ(lab.session.status(lab.now).resynchronisations, 0u);
}

TEST(OpenSession, ARobotThatRestartsIsStoppedFirst) {
  OpenLab lab;
  lab.open();
  lab.command(1000, 1000);
  lab.exchange();
  lab.robot.boot();
  lab.command(1001, 1000);
  lab.session.received(ask_open(lab.robot, lab.take()), lab.now);
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).reason, "the robot restarted");
  lab.exchange();
  EXPECT_TRUE(lab.session.up());
}

/// A status that says these speeds, in a frame with this number and version.
Bytes said(std::uint16_t number, int left, int right, std::uint8_t version = 1) {
  Bytes payload(15, 0);
  const auto put = [&](std::size_t at, int value) {
    payload[at] = static_cast<std::uint8_t>(value & 255);
    payload[at + 1] = static_cast<std::uint8_t>(value >> 8 & 255);
  };
  put(1, left), put(3, right);
  Bytes frame = open_frame('s', number, payload);
  frame[2] = version;
  const std::uint16_t sum = open_robot_crc(frame.data() + 2, frame.size() - 4);
  frame[frame.size() - 2] = static_cast<std::uint8_t>(sum & 255);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(sum >> 8);
  return frame;
}
std::uint16_t number_of(const Bytes& frame) {
  return static_cast<std::uint16_t>(frame.at(4) | frame.at(5) << 8);
}

TEST(OpenSession, AnswersOfAnotherVersionAreNoneAndTheReasonSaysSo) {
  OpenLab lab;
  lab.session.opened(lab.now);
  for (int k = 0; k < 20; ++k) {
    const Bytes stop = lab.take();
    if (!stop.empty()) lab.session.received(said(number_of(stop), 0, 0, 2), lab.now);
    lab.pass(0.05);
  }
  EXPECT_FALSE(lab.session.up());
  EXPECT_FALSE(lab.session.stop_acknowledged());
  EXPECT_EQ(lab.session.status(lab.now).reason, "the robot speaks version 2 of the open protocol, allowed: 1");
  EXPECT_FALSE(open_acknowledged(said(0, 0, 0, 2)));
  lab.exchange();
  lab.pass(0.25);
  lab.exchange();
  EXPECT_TRUE(lab.session.up()) << "one of version 1 is there after all";
}

TEST(OpenSession, AnAnswerWithANumberThatWasNeverSentIsNone) {
  OpenLab lab;
  lab.session.opened(lab.now);
  const std::uint16_t first = number_of(lab.take());  // two stops
  lab.session.received(said(static_cast<std::uint16_t>(first + 7), 0, 0), lab.now);
  lab.session.received(said(static_cast<std::uint16_t>(first + 2), 0, 0), lab.now);
  EXPECT_FALSE(lab.session.stop_acknowledged()) << "of no frame that was sent";
  lab.session.received(said(static_cast<std::uint16_t>(first + 1), 0, 0), lab.now);
  EXPECT_TRUE(lab.session.stop_acknowledged());
  lab.command(1000, 1000);
  const std::uint16_t wheels = number_of(lab.take());
  lab.session.received(said(static_cast<std::uint16_t>(wheels + 1), 1000, 1000), lab.now);
  EXPECT_EQ(lab.session.status(lab.now).exchanges, 0u);
  lab.session.received(said(wheels, 1000, 1000), lab.now);
  EXPECT_EQ(lab.session.status(lab.now).exchanges, 1u);
  lab.session.stop(lab.now);
  const std::uint16_t stop = number_of(lab.take());
  lab.session.received(said(wheels, 0, 0), lab.now);
  EXPECT_FALSE(lab.session.stop_acknowledged()) << "it stood before it was told to";
  lab.session.received(said(stop, 0, 0), lab.now);
  EXPECT_TRUE(lab.session.stop_acknowledged());
  EXPECT_FALSE(open_acknowledged(said(1, 0, 0))) << "the guard's stops have the number 0";
  EXPECT_TRUE(open_acknowledged(said(0, 0, 0)));
}

TEST(OpenSession, AStopIsAcknowledgedAfterHoursWithoutAnAnswer) {
  OpenLab lab;
  lab.session.opened(lab.now);
  for (int k = 0; k < 20000; ++k) {
    lab.take();
    lab.pass(0.3);
  }
  lab.exchange();
  EXPECT_TRUE(lab.session.stop_acknowledged());
}

TEST(OpenSession, ARobotThatTakesOtherSpeedsIsToldNoOftenerThanOnceATick) {
  OpenLab lab;
  lab.open();
  int told = 0, frames = 0;
  for (int tick = 0; tick < 50; ++tick) {
    lab.command(1000, 500);
    for (int k = 0; k < 20 && !lab.session.output().empty(); ++k) {  // it answers at once
      const Bytes request = lab.take();
      OpenParser parser;
      parser.feed(request);
      while (const auto frame = parser.next()) {
        ++frames, told += frame->kind == 'W';
        lab.session.received(frame->kind == 'W' ? said(frame->number, 5000, 5000) : said(frame->number, 0, 0), lab.now);
      }
    }
    lab.pass(0.04);
  }
  EXPECT_EQ(told, 50);
  EXPECT_LE(frames, 3 * 50) << "and two stops";
  EXPECT_EQ(lab.session.status(lab.now).wrong_speeds, 50u);
}

TEST(OpenFuzz, WhateverHostsAndRobotsSay) {
  core::Random random(20101208, 3);
  const auto below = [&](std::size_t limit) {
    return static_cast<std::size_t>(random.uniform() * static_cast<double>(limit));
  };
  for (const Bytes& seed : {wheels(2, 1000, -1000), open_frame('X', 1), open_frame('s', 3, Bytes(15, 1)),
                            test::bytes("d\r\nr,1000,-2000\r\nv,7800\r\nb,A,1\r\n$\r\n")}) {
    Bytes bytes = seed;
    for (int i = 0; i < 1500; ++i) {
      if (i % 50 == 0) bytes = seed;
      for (std::size_t changes = 1 + below(6); changes > 0; --changes) {
        const auto at = static_cast<std::ptrdiff_t>(below(bytes.size()));
        if (random.uniform() < 0.4)
          bytes.insert(bytes.begin() + at, static_cast<std::uint8_t>(below(256)));
        else if (random.uniform() < 0.4)
          bytes.insert(bytes.end(), seed.begin(), seed.end());
        else
          bytes[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(below(256));
      }
      fuzz::to_open_robot(bytes);
      fuzz::from_open_robot(bytes);
      fuzz::from_khepera(bytes);
    }
  }
}

/// Over any radio: whatever failed, one stop stops it and the link comes up.
TEST(OpenSession, ComesUpAfterAnyRadioFaults) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    std::vector<Fault> faults{{.kind = FaultKind::loss, .at = 1.0, .duration = 3.0, .share = 0.5},
                              {.kind = FaultKind::corruption, .at = 2.0, .duration = 3.0, .share = 0.1},
                              {.kind = FaultKind::reboot, .at = 4.0, .duration = 0.5},
                              {.kind = FaultKind::disconnect, .at = 6.0, .duration = 0.2}};
    OpenSession session({.command_silence = 0.0});
    test::expect_stopped_after(faults, open_type(), session, {500, 500}, seed);
  }
}

/// Robots behind the kernel's own UDP sockets.
struct UdpRobots {
  explicit UdpRobots(std::size_t count) {
    std::vector<EmulatorLoop::Robot> robots;
    for (std::size_t i = 0; i < count; ++i) {
      robots.emplace_back();
      robots.back().endpoint = make_socket_endpoint({LinkKind::udp, "127.0.0.1", 0});
      robots.back().firmware = make_firmware(open_type());
    }
    loop.emplace(std::move(robots), nullptr, seconds, std::vector<Fault>{}, 1);
  }
  std::vector<LinkAddress> addresses() const {
    std::vector<LinkAddress> all;
    for (std::size_t i = 0; i < loop->size(); ++i) all.push_back(*parse_link_address(loop->address(i)));
    return all;
  }
  std::optional<EmulatorLoop> loop;
};

TEST(OpenOverUdp, RobotsAreDrivenAndStopped) {
  UdpRobots robots(3);
  LinkSupervisor links(robots.addresses(), {.heartbeat = 0.05, .ask_version = true});
  ASSERT_TRUE(links.start(5.0));
  for (int tick = 0; tick < 25; ++tick) {
    for (std::size_t i = 0; i < 3; ++i) links.command(i, 1000, 2000);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(robots.loop->wheels(i), (WheelSpeeds{1000, 2000}));
    EXPECT_EQ(links.status()[i].version, "emulated, open protocol");
    EXPECT_GT(links.status()[i].right_steps, links.status()[i].left_steps);
  }
  for (const LinkStatus& status : links.close(2.0)) EXPECT_TRUE(status.stop_acknowledged);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(robots.loop->wheels(i), WheelSpeeds{});
}

TEST(OpenOverUdp, ARobotThatIsNotThereIsSaidAndReachedLater) {
  int port = 0;
  {
    const UdpRobots robots(1);
    port = robots.addresses()[0].channel;
  }
  LinkSupervisor links({{LinkKind::udp, "127.0.0.1", port}}, {.reconnect_first = 0.02, .close_timeout = 0.1});
  const auto started = links.start(2.0);
  ASSERT_FALSE(started);
  EXPECT_NE(started.error().find("nothing listens on port"), std::string::npos) << started.error();
}

/// The commander is killed in the middle of driving, without a guard: the robot's own watchdog stops it.
TEST(OpenOverUdp, ARobotStopsWhenItsCommanderDies) {
  // Forked before there is any thread: a lock that another thread holds at that moment would stay held for ever.
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t commander = ::fork();
  ASSERT_GE(commander, 0);
  if (commander == 0) {
    int port = 0;
    if (::read(pipe[0], &port, sizeof port) != sizeof port) ::_exit(1);
    LinkSupervisor links({{LinkKind::udp, "127.0.0.1", port}});
    if (!links.start(5.0)) ::_exit(1);
    while (true) {
      links.command(0, 1500, 1500);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  UdpRobots robots(1);
  const int port = robots.addresses()[0].channel;
  ASSERT_EQ(::write(pipe[1], &port, sizeof port), static_cast<ssize_t>(sizeof port));
  ::close(pipe[0]);
  ::close(pipe[1]);
  EXPECT_TRUE(test::wait_until([&] { return robots.loop->wheels(0) == WheelSpeeds{1500, 1500}; }, 10.0));
  ASSERT_EQ(::kill(commander, SIGKILL), 0);
  ::waitpid(commander, nullptr, 0);
  const double died = seconds();
  EXPECT_TRUE(test::wait_until([&] { return robots.loop->wheels(0) == WheelSpeeds{}; }, 10.0));
  RecordProperty("stopped_after_s", std::to_string(seconds() - died));
}

TEST(Protocols, EveryTypeOfRobotHasOneAndAStopThatFits) {
  for (const core::RobotType& type : core::robot_types) {
    if (type.protocol.empty()) continue;
    const Protocol* const protocol = find_protocol(type.protocol);
    ASSERT_NE(protocol, nullptr) << type.name;
    EXPECT_NEAR(protocol->unit.metres_per_step, type.wheels.metres_per_step(), 1e-9) << type.name;
    EXPECT_GE(protocol->unit.fastest, type.wheels.max_step_rate) << type.name;
    EXPECT_NE(make_firmware(type), nullptr) << type.name;
  }
  for (const Protocol& protocol : protocols()) {
    EXPECT_FALSE(protocol.stop_bytes().empty());
    EXPECT_LE(protocol.stop_bytes().size(), std::size_t{longest_stop}) << protocol.name;
    EXPECT_FALSE(protocol.acknowledged({})) << protocol.name;
    EXPECT_NE(protocol.make_session({}), nullptr);
  }
}

TEST(Protocols, AnAddressSaysWhatIsSpokenThere) {
  for (const char* text : {"udp:192.168.1.20:2626", "open+serial:/dev/ttyUSB0", "khepera4+rfcomm:10:00:E8:AA:BB:CC/1",
                           "tcp:192.168.1.20:1000", "serial:/dev/ttyACM0"}) {
    const auto address = parse_link_address(text);
    ASSERT_TRUE(address) << address.error();
    EXPECT_EQ(to_text(*address), text);
  }
  EXPECT_EQ(to_text(*parse_link_address("udp:robot-1.lab")), "udp:robot-1.lab:2626");
  EXPECT_EQ(to_text(*parse_link_address("open+udp:a:1")), "udp:a:1");
  EXPECT_EQ(protocol_of(*parse_link_address("khepera4+serial:/dev/rfcomm0")).name, "khepera4");
  EXPECT_EQ(protocol_of(*parse_link_address("serial:/dev/rfcomm0")).name, "asercom");
  const auto unknown = parse_link_address("lego+serial:/dev/ttyUSB0");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().find("there is no protocol \"lego\"; allowed before the +: \"asercom\""), std::string::npos)
      << unknown.error();
  const auto spoken = spoken_by(*parse_link_address("serial:/dev/ttyUSB0"), "open");
  ASSERT_TRUE(spoken);
  EXPECT_EQ(to_text(*spoken), "open+serial:/dev/ttyUSB0");
  EXPECT_FALSE(spoken_by(*parse_link_address("khepera4+serial:/dev/rfcomm0"), "open"));
  EXPECT_FALSE(spoken_by(*parse_link_address("udp:a"), "")) << "an e-puck has no such link";
}

}  // namespace
}  // namespace skein::comms
