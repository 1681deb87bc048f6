// A Khepera IV: lines as K-Team's server on the robot writes and reads them, the session, and the emulated robot.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "comms/emulator/emulated_epuck.h"
#include "comms/emulator/khepera_firmware.h"
#include "comms/emulator/make_firmware.h"
#include "comms/emulator/pty_emulator.h"
#include "comms/khepera_session.h"
#include "comms/link_supervisor.h"
#include "tests/comms/bytes.h"
#include "tests/comms/radio_faults.h"
#include "tests/comms/wait_until.h"

namespace skein::comms {
namespace {

using core::WheelSpeeds;
using test::Bytes;

const core::RobotType& khepera() {
  return *core::find_robot_type("khepera4");
}

std::string ask(RobotFirmware& robot, std::string_view request) {
  Bytes reply;
  robot.receive(test::bytes(request), reply);
  return test::text(reply);
}

TEST(KheperaRobot, AnswersAsKTeamsServerDoes) {
  KheperaFirmware robot(khepera());
  EXPECT_EQ(ask(robot, "B\n"), "b,A,1\r\n");
  EXPECT_EQ(ask(robot, "D,300,-200\n"), "d\r\n");
  EXPECT_EQ(robot.told(), (WheelSpeeds{300, -200}));
  EXPECT_EQ(ask(robot, "E\n"), "e,300,-200\r\n");
  robot.advance(2.0);
  EXPECT_EQ(ask(robot, "R\n"), "r,60000,-40000\r\n") << "a speed of 1 is 100 pulses a second";
  EXPECT_EQ(ask(robot, "I\n"), "i\r\n");
  EXPECT_EQ(ask(robot, "R\n"), "r,0,0\r\n");
  EXPECT_EQ(ask(robot, "V,0\n"), "v,8000\r\n");
  EXPECT_EQ(ask(robot, "?\n"), "$\r\n");
  EXPECT_EQ(ask(robot, "\r\n"), "") << "an empty line has no answer";
}

TEST(KheperaRobot, ThrowsAwayWhatComesWhileItAnswersAndMakesUpArguments) {
  KheperaFirmware robot(khepera());
  EXPECT_EQ(ask(robot, "D,100,100\nD,0,0\n"), "d\r\n");
  EXPECT_EQ(robot.told(), (WheelSpeeds{100, 100})) << "the second line was lost";
  EXPECT_EQ(ask(robot, "D,7\n"), "d\r\n");
  EXPECT_EQ(robot.told(), (WheelSpeeds{7, 100}));
}

TEST(KheperaCodec, PulsesAreHundredthsOfASpeedTimesASecond) {
  EXPECT_EQ(khepera_steps(60000), 600);
  EXPECT_EQ(khepera_steps(99), 0);
  EXPECT_EQ(khepera_steps(-1), -1) << "downwards, so that equal ways count equally";
  EXPECT_EQ(khepera_steps(-100), -1);
  EXPECT_EQ(khepera_steps(100LL * 32768), -32768) << "wraps around, as counters do";
  EXPECT_EQ(test::text(khepera_stop()), "\nD,0,0\n");
  EXPECT_TRUE(khepera_acknowledged(test::bytes("r,1,2\r\nd\r\n")));
  EXPECT_FALSE(khepera_acknowledged(test::bytes("r,1,2\r\n$\r\n")));
}

struct KheperaLab {
  explicit KheperaLab(LinkOptions options = {}) : session(options) {}
  std::string take() {
    const std::string out(session.output().begin(), session.output().end());
    session.sent(out.size(), now);
    return out;
  }
  void exchange() {
    for (int k = 0; k < 12 && !session.output().empty(); ++k) session.received(test::bytes(ask(robot, take())), now);
  }
  void pass(double dt) {
    robot.advance(dt);
    now += dt;
    session.advance(now);
  }
  void command(int left, int right) {
    session.command({static_cast<std::int16_t>(left), static_cast<std::int16_t>(right)}, ++ticket, now);
  }
  double now = 100.0;
  KheperaSession session;
  KheperaFirmware robot{khepera()};
  std::uint16_t ticket = 0;
};

TEST(KheperaSession, SendsOneLineAtATime) {
  KheperaLab lab({.battery_period = 1.0, .ask_version = true});
  lab.session.opened(lab.now);
  EXPECT_EQ(lab.take(), "\nD,0,0\n");
  lab.session.received(test::bytes("d\r\n"), lab.now);
  EXPECT_EQ(lab.take(), "D,0,0\n") << "the first may have been the answer to what was broken off";
  lab.session.received(test::bytes("d\r\n"), lab.now);
  EXPECT_TRUE(lab.session.stop_acknowledged());
  EXPECT_EQ(lab.take(), "B\n");
  EXPECT_FALSE(lab.session.up());
  lab.session.received(test::bytes("b,A,1\r\n"), lab.now);
  EXPECT_TRUE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).version, "Khepera IV A,1");

  lab.command(300, -200);
  EXPECT_EQ(lab.take(), "D,300,-200\n");
  lab.command(310, -200);
  EXPECT_EQ(lab.take(), "") << "it would be thrown away";
  lab.session.received(test::bytes("d\r"), lab.now);
  EXPECT_EQ(lab.take(), "R\n");
  lab.session.received(test::bytes("\nr,1000,-2000\r\n"), lab.now);
  EXPECT_EQ(lab.take(), "V,0\n");
  lab.session.received(test::bytes("v,7654\r\n"), lab.now);
  EXPECT_EQ(lab.take(), "D,310,-200\n") << "the newest command waited for it";
  EXPECT_NEAR(lab.session.status(lab.now).battery.volts, 7.654, 1e-9);
}

TEST(KheperaSession, DrivesAndCounts) {
  KheperaLab lab;
  lab.session.opened(lab.now);
  lab.exchange();
  ASSERT_TRUE(lab.session.up());
  for (int tick = 0; tick < 100; ++tick) {
    lab.command(150, 75);
    lab.exchange();
    lab.pass(0.04);
  }
  const LinkStatus status = lab.session.status(lab.now);
  EXPECT_NEAR(static_cast<double>(status.left_steps), 594, 7);
  EXPECT_NEAR(static_cast<double>(status.right_steps), 297, 4);
  EXPECT_EQ(status.resynchronisations, 0u);
}

// The control is WifiSession.ARobotThatSomebodyElseDrivesWhileItIsToStandIsStopped: an e-puck counts its motors' steps.
TEST(KheperaSession, WheelsThatAHandTurnsAreNoRobotThatDrives) {
  KheperaLab lab;
  lab.session.opened(lab.now);
  lab.exchange();
  ASSERT_TRUE(lab.session.up());
  for (int k = 0; k < 5; ++k) {
    lab.pass(1.0);
    ASSERT_EQ(lab.take(), "R\n");
    lab.session.received(test::bytes("r," + std::to_string(700 * k) + ",0\r\n"), lab.now);
    EXPECT_TRUE(lab.session.up());
  }
  EXPECT_EQ(lab.session.status(lab.now).resynchronisations, 0u);
  EXPECT_EQ(lab.session.status(lab.now).left_steps, 28);
}

TEST(KheperaSession, ADThatAnswersWhatWasBrokenOffIsNoAcknowledgement) {
  KheperaLab lab;
  (void)ask(lab.robot, "D,100,10");  // what another host has left behind
  lab.session.opened(lab.now);
  lab.session.received(test::bytes(ask(lab.robot, lab.take())), lab.now);
  EXPECT_EQ(lab.robot.told(), (WheelSpeeds{100, 10})) << "the server has carried out the debris";
  EXPECT_FALSE(lab.session.stop_acknowledged());
  lab.exchange();
  EXPECT_TRUE(lab.session.stop_acknowledged());
  EXPECT_EQ(lab.robot.told(), WheelSpeeds{});
}

TEST(KheperaSession, AVersionIsNoAcknowledgementOfAStop) {
  KheperaLab lab({.ask_version = true});
  lab.session.opened(lab.now);
  lab.session.received(test::bytes("b,A,1\r\n"), lab.now);  // what another host had asked
  EXPECT_FALSE(lab.session.up());
  lab.exchange();
  EXPECT_TRUE(lab.session.up() && lab.session.stop_acknowledged());
}

TEST(KheperaSession, WhatItDoesNotUnderstandLeadsToTheStop) {
  KheperaLab lab;
  lab.session.opened(lab.now);
  lab.exchange();
  lab.command(300, 300);
  (void)lab.take();
  lab.session.received(test::bytes("$\r\n"), lab.now);
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).reason, "the robot did not understand a command");
  lab.exchange();
  EXPECT_TRUE(lab.session.up());
}

/// Commands 25 times a second over a line that repeats what it carries. How often the robot began to drive.
int drive_over(KheperaLab& lab, int answers, bool echo, int ticks) {
  int starts = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    lab.command(300, 300);
    for (int exchange = 0; exchange < 8; ++exchange) {
      const bool stood = lab.robot.told() == WheelSpeeds{};
      const std::string sent = lab.take();
      std::string heard = echo ? sent : "";
      const std::string answer = ask(lab.robot, sent);
      for (int k = 0; k < answers; ++k) heard += answer;
      if (stood && lab.robot.told() != WheelSpeeds{}) ++starts;
      lab.session.received(test::bytes(heard), lab.now);
      lab.pass(0.005);
    }
  }
  return starts;
}

TEST(KheperaSession, OverALineWithAnEchoARobotStandsAndTheReasonSaysSo) {
  KheperaLab lab;
  lab.session.opened(lab.now);
  EXPECT_EQ(drive_over(lab, 1, true, 100), 0);
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).reason,
            "the line returns what is sent to it (an echo in its cable, adapter or radio)");
  EXPECT_EQ(drive_over(lab, 1, false, 25), 1) << "it comes up when the echo ends";
  EXPECT_TRUE(lab.session.up());
}

TEST(KheperaSession, ARobotThatAnswersEverythingTwiceStandsAndTheReasonSaysSo) {
  KheperaLab lab({.ask_version = true});
  lab.session.opened(lab.now);
  EXPECT_LE(drive_over(lab, 2, false, 25), 4) << "a line too many may be noise";
  EXPECT_EQ(drive_over(lab, 2, false, 100), 0);
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.robot.told(), WheelSpeeds{});
  EXPECT_EQ(lab.session.status(lab.now).reason,
            "each stop is answered more than once (does another robot hear the same line?)");
  EXPECT_EQ(drive_over(lab, 1, false, 25), 1);
  EXPECT_TRUE(lab.session.up());
}

TEST(KheperaSession, ComesUpAfterAnyRadioFaults) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const std::vector<Fault> faults{{.kind = FaultKind::corruption, .at = 1.0, .duration = 3.0, .share = 0.1},
                                    {.kind = FaultKind::loss, .at = 2.0, .duration = 3.0, .share = 0.3},
                                    {.kind = FaultKind::reboot, .at = 5.0, .duration = 0.5}};
    KheperaSession session({.command_silence = 0.0});
    test::expect_stopped_after(faults, khepera(), session, {200, 200}, seed);
  }
}

TEST(KheperaOverALine, IsDrivenAndStopped) {
  const auto seconds = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  PtyEmulator robots(std::vector{&khepera()}, nullptr, seconds);
  LinkSupervisor links({*spoken_by({LinkKind::serial, robots.device(0)}, "khepera4")}, {.heartbeat = 0.05});
  const auto started = links.start(5.0);
  ASSERT_TRUE(started) << started.error();
  const WheelSpeeds fastest{150, 1200};
  for (int tick = 0; tick < 25 || (tick < 250 && robots.wheels(0) != fastest); ++tick) {
    links.command(0, 150, 2000);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_EQ(robots.wheels(0), fastest) << "no faster than it goes";
  EXPECT_TRUE(links.close(2.0)[0].stop_acknowledged);
  EXPECT_EQ(robots.wheels(0), WheelSpeeds{});
}

}  // namespace
}  // namespace skein::comms
