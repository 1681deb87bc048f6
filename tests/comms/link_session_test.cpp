#include "comms/asercom_session.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

#include "comms/emulator/epuck_firmware.h"
#include "tests/comms/bytes.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using test::Bytes;
using test::bytes;

const Bytes exact_stop(stop_sequence().begin(), stop_sequence().end());
const Bytes question = wheel_request({}, Question::wheels);

/// The answer of a robot that has taken these speeds, its counters at 0.
Bytes answer(int left, int right) {
  Bytes bytes(8, 0);
  const WheelCommand taken = clamped(left, right);
  std::memcpy(bytes.data(), &taken.left, 2);
  std::memcpy(bytes.data() + 2, &taken.right, 2);
  return bytes;
}

/// A session and an emulated robot on a clock of their own, with the link between them in the test's hands.
struct Lab {
  explicit Lab(LinkOptions options = {}, core::MotorModel model = core::MotorModel::epuck2)
      : session(options), robot(model) {}

  /// What the session wants to send now; taken off it.
  Bytes take() {
    Bytes out(session.output().begin(), session.output().end());
    session.sent(out.size(), now);
    return out;
  }
  /// Carries bytes to and fro until nobody has anything to say.
  void talk() {
    while (!session.output().empty()) {
      Bytes reply;
      robot.receive(take(), reply);
      session.received(reply, now);
    }
  }
  void pass(double seconds) {
    robot.advance(seconds);
    now += seconds;
    session.advance(now);
  }
  /// To the session's next deadline.
  void pass() { pass(std::max(0.0, session.deadline() - now)); }
  void command(int left, int right) { session.command(clamped(left, right), ++ticket, now); }
  void open() {
    session.opened(now);
    talk();
    ASSERT_TRUE(session.up());
  }
  LinkState state() const { return session.status(now).state; }

  double now = 1000.0;
  AsercomSession session;
  EpuckFirmware robot;
  std::uint16_t ticket = 0;
};

TEST(LinkSession, OpensWithTheStopSequence) {
  Lab lab;
  EXPECT_EQ(lab.state(), LinkState::down);
  lab.session.opened(lab.now);
  EXPECT_EQ(lab.state(), LinkState::synchronising);
  EXPECT_EQ(lab.take(), exact_stop);
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_EQ(lab.state(), LinkState::up);
  EXPECT_TRUE(lab.session.stop_acknowledged());
}

TEST(LinkSession, RepeatsTheStopUntilItIsAnswered) {
  Lab lab;
  lab.session.opened(lab.now);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(lab.take(), exact_stop);
    EXPECT_FALSE(lab.session.stop_acknowledged());
    lab.pass();
  }
  EXPECT_EQ(lab.state(), LinkState::stale);
  EXPECT_EQ(lab.session.status(lab.now).timeouts, 5u);
  // Six answers were asked for; the link is up when all have come, so that none is mistaken for something else.
  lab.take();
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_TRUE(lab.session.stop_acknowledged());
  EXPECT_FALSE(lab.session.up());
  for (int i = 0; i < 5; ++i) lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_TRUE(lab.session.up());
}

TEST(LinkSession, OfASilentRobotTheReasonSaysHowLongItHasBeenAsked) {
  Lab lab;
  lab.session.opened(lab.now);
  while (lab.now < 1015.0) {
    lab.take();
    lab.pass(0.1);
  }
  EXPECT_EQ(lab.session.status(lab.now).reason, "no answer to the stop within 14.9 s");
  lab.session.lost("test", lab.now);
  lab.session.opened(lab.now);
  lab.pass();
  EXPECT_EQ(lab.session.status(lab.now).reason, "no answer to the stop within 0.1 s") << "on the new link";
}

TEST(LinkSession, DoesNotWaitForeverForAnswersToRepetitions) {
  Lab lab;
  lab.session.opened(lab.now);
  lab.take();
  lab.pass();
  lab.take();
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_FALSE(lab.session.up());
  lab.pass();
  EXPECT_TRUE(lab.session.up());
  // They may be late, not lost: an exchange finds out.
  EXPECT_EQ(lab.take(), question);
  lab.session.received(bytes("s\r"), lab.now);
  lab.session.received(bytes(std::string_view("\n\0\0\0\0\0\0\0\0", 9)), lab.now);
  EXPECT_TRUE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).exchanges, 1u);
}

TEST(LinkSession, OverASlowRadioARobotIsAskedForItsVersionToo) {
  Lab lab({.ask_version = true});
  lab.session.opened(lab.now);
  lab.take();
  lab.pass();
  lab.take();
  lab.session.received(bytes("s\r\n"), lab.now);
  lab.pass();  // the answer to the repetition is late
  Bytes asked = bytes("V\n");
  asked.insert(asked.end(), exact_stop.begin(), exact_stop.end());
  EXPECT_EQ(lab.take(), asked);
  lab.pass();
  EXPECT_TRUE(lab.take().empty()) << "so is the one to that";
  EXPECT_FALSE(lab.session.up());
  lab.session.received(bytes("s\r\nv,Version 2.0\r\nHW version: FFFF\r\ns\r\n"), lab.now);
  EXPECT_TRUE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).version, "Version 2.0");
  // A robot that does not say is not waited for, nor asked again.
  Lab mute({.ask_version = true});
  mute.session.opened(mute.now);
  mute.take();
  mute.session.received(bytes("s\r\n"), mute.now);
  EXPECT_EQ(mute.take(), asked);
  mute.session.received(bytes("s\r\n"), mute.now);
  EXPECT_TRUE(mute.session.up());
  Lab deaf({.ask_version = true});
  deaf.session.opened(deaf.now);
  deaf.take();
  deaf.session.received(bytes("s\r\n"), deaf.now);
  EXPECT_EQ(deaf.take(), asked);
  const double since = deaf.now;
  for (int i = 0; i < 100 && !deaf.session.up(); ++i) deaf.pass();
  EXPECT_TRUE(deaf.session.up());
  EXPECT_LE(deaf.now, since + LinkOptions{}.reply_timeout + LinkOptions{}.stop_repeat + 1e-6);
}

/// Robots are swapped, renumbered and flashed while a run waits for them.
TEST(LinkSession, AnotherRobotOnTheNextConnectionIsAskedWhatItIs) {
  Lab lab({.ask_version = true});
  lab.open();
  const std::string before = lab.session.status(lab.now).version;
  EXPECT_EQ(before, "Version 2.0 January 2018 GCtronic");
  lab.session.lost("the line hung up", lab.now);
  lab.open();
  EXPECT_EQ(lab.session.status(lab.now).reason, "the line hung up") << "the control: the same robot";
  lab.session.lost("the line hung up", lab.now);
  lab.robot = EpuckFirmware(core::MotorModel::epuck1);
  lab.open();
  const LinkStatus status = lab.session.status(lab.now);
  EXPECT_EQ(status.version, "Version 1.2.2 August 2008 GCtronic");
  EXPECT_EQ(status.reason, "the robot says that it is \"" + status.version + "\"; before, it was \"" + before + "\"");
}

TEST(LinkSession, AVersionIsALineThatCanBePrinted) {
  const auto version = [](const std::string& said) {
    Lab lab({.ask_version = true});
    lab.session.opened(lab.now);
    lab.take();
    lab.session.received(bytes("s\r\n"), lab.now);
    lab.take();
    lab.session.received(bytes("v," + said + "\r\ns\r\n"), lab.now);
    EXPECT_TRUE(lab.session.up());
    return lab.session.status(lab.now).version;
  };
  EXPECT_EQ(version("Version \"2\""), "Version \"2\"");
  EXPECT_EQ(version("Ver\x1b[31m\a\xff\xfesion"), "Ver[31msion");
  EXPECT_EQ(version(std::string(3000, 'V')), std::string(longest_version, 'V'));
}

TEST(LinkSession, ALateAnswerToAnOldStopIsNoAnswerToANewOne) {
  Lab lab({.command_silence = 0.0});
  lab.session.opened(lab.now);
  lab.take();
  lab.pass();
  lab.take();
  lab.session.received(bytes("s\r\n"), lab.now);
  lab.pass();
  lab.take();
  lab.command(100, 100);
  lab.session.stop(lab.now);
  lab.take();
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_FALSE(lab.session.stop_acknowledged());
  lab.session.received(Bytes{0, 0, 0, 0, 's', '\r', '\n'}, lab.now);
  EXPECT_TRUE(lab.session.stop_acknowledged());
}

TEST(LinkSession, ALateAnswerDoesNotPutOffTheRepetitionOfALostStop) {
  Lab lab({.command_silence = 0.0});
  lab.session.opened(lab.now);
  lab.take();
  lab.pass();
  lab.take();
  lab.session.received(bytes("s\r\n"), lab.now);  // one of two
  lab.pass();
  lab.take();
  lab.session.received(Bytes{0, 0}, lab.now);
  lab.command(100, 100);
  lab.session.stop(lab.now);
  lab.take();  // lost
  const double sent = lab.now;
  lab.pass(0.05);
  lab.session.received(bytes("s\r\n"), lab.now);  // the answer to the first stop
  EXPECT_FALSE(lab.session.stop_acknowledged());
  EXPECT_NEAR(lab.session.deadline(), sent + LinkOptions{}.stop_repeat, 1e-9);
}

TEST(LinkSession, OneRequestSetsSpeedsAndReadsThemBackWithTheCounters) {
  Lab lab;
  lab.open();
  lab.command(100, -200);
  EXPECT_EQ(lab.take(), (Bytes{0, 0, 0, 0, 0xBC, 0x64, 0x00, 0x38, 0xFF, 0xBB, 0xAF, 0x00}));
  EXPECT_FALSE(lab.session.stop_acknowledged());
  lab.pass(0.003);
  lab.session.received(answer(100, -200), lab.now);
  const LinkStatus status = lab.session.status(lab.now);
  EXPECT_EQ(status.exchanges, 1u);
  EXPECT_NEAR(status.rtt_median, 0.003, 1e-9);
  EXPECT_EQ(status.bytes_sent, exact_stop.size() + 12u);
  EXPECT_EQ(status.bytes_received, 3u + 8u);
  EXPECT_EQ(lab.session.answered_ticket(), lab.ticket);
}

TEST(LinkSession, SpeedsGoOutWhileAnAnswerIsOwedTheQuestionWaits) {
  Lab lab;
  lab.open();
  lab.command(1, 1);
  lab.take();
  lab.command(2, 2);
  EXPECT_EQ(lab.take(), (Bytes{0, 0, 0, 0, 0xBC, 2, 0, 2, 0, 0}));
  lab.command(3, 3);
  EXPECT_EQ(lab.take(), (Bytes{0, 0, 0, 0, 0xBC, 3, 0, 3, 0, 0}));
  const Bytes first = answer(1, 1);
  lab.session.received(std::span(first).first(5), lab.now);  // a part of it
  EXPECT_EQ(lab.take(), Bytes{});
  lab.session.received(std::span(first).subspan(5), lab.now);
  EXPECT_EQ(lab.session.answered_ticket(), 1u);
  EXPECT_EQ(lab.take(), question) << "at once: two commands are not confirmed";
  lab.session.received(answer(3, 3), lab.now);
  EXPECT_EQ(lab.session.answered_ticket(), 3u);
  EXPECT_EQ(lab.take(), Bytes{});
}

TEST(LinkSession, NoMoreCommandsGoOutUnconfirmedThanAnEpuck1CanReceiveAtOnce) {
  Lab lab({.blind_distance = 0.0, .reply_timeout = 10.0});
  lab.open();
  std::size_t bytes = 0;
  for (int speed = 1; speed <= 20; ++speed) {
    lab.command(speed, speed);
    bytes += lab.take().size();
  }
  EXPECT_LE(bytes, 58u);
  lab.session.received(answer(1, 1), lab.now);
  EXPECT_EQ(lab.take(), wheel_request(WheelCommand{20, 20}, Question::wheels)) << "the newest; the others are void";
}

TEST(LinkSession, SpeedsThatTheRobotHasAreNotSentAgainButAskedFor) {
  Lab lab;
  lab.open();
  lab.command(300, 300);
  lab.talk();
  lab.command(300, 300);
  EXPECT_EQ(lab.take(), question);
  lab.session.received(answer(300, 300), lab.now);
  EXPECT_EQ(lab.session.answered_ticket(), lab.ticket);
  lab.session.stop(lab.now);
  lab.talk();
  lab.command(300, 300);
  EXPECT_EQ(lab.take(), wheel_request(WheelCommand{300, 300}, Question::wheels)) << "a stop takes them away";
}

TEST(LinkSession, ARobotThatTookOtherSpeedsIsStoppedWithinThatRoundTrip) {
  Lab lab;
  lab.open();
  Bytes reply;
  lab.command(300, 300);
  Bytes changed = lab.take();
  std::ranges::replace(changed, std::uint8_t{0x2C}, std::uint8_t{0xBC});  // on its way: 444 for 300
  lab.robot.receive(changed, reply);
  EXPECT_NE(lab.robot.wheels(), (core::WheelSpeeds{300, 300}));
  lab.session.received(reply, lab.now);
  EXPECT_EQ(lab.take(), exact_stop);
  EXPECT_EQ(lab.session.status(lab.now).wrong_speeds, 1u);
  EXPECT_NE(lab.session.status(lab.now).reason.find("the robot took the speeds"), std::string::npos);
}

TEST(LinkSession, ARobotWhoseHalfLineAByteOfOursHasEndedIsStoppedWithinThatRoundTrip) {
  Lab lab;
  lab.open();
  Bytes reply;
  lab.robot.receive(bytes("D,900,900"), reply);  // by a host that died
  lab.command(13, 342);  // 0D 00 56 01: a line's end, and the letter V, which begins the next line
  lab.robot.receive(lab.take(), reply);
  EXPECT_EQ(lab.robot.told(), (core::WheelSpeeds{900, 900}));
  EXPECT_EQ(reply, bytes("d\r\n"));
  lab.session.received(reply, lab.now);
  EXPECT_EQ(lab.take(), exact_stop);
}

// What is left of a speed command in the robot's parser, and the zeros with which the next request begins.
TEST(LinkSession, ARobotThatDrivesThoughItWasStoppedIsStoppedWithinThatRoundTrip) {
  for (const bool driven_before : {true, false}) {
    Lab lab;
    lab.open();
    if (driven_before) {
      lab.command(400, 400);
      lab.talk();
      lab.session.stop(lab.now);
      lab.talk();
    }
    for (int k = 0; k < 3; ++k) {
      lab.pass();  // a heartbeat: the robot reports the speeds from before its stop
      lab.talk();
      ASSERT_EQ(lab.session.status(lab.now).resynchronisations, 0u) << "the control: it stands";
    }
    Bytes reply;
    lab.robot.receive(bytes("\xBC\x64\x03"), reply);
    lab.pass();
    lab.robot.receive(lab.take(), reply);
    ASSERT_NE(lab.robot.wheels(), core::WheelSpeeds{});
    lab.session.received(reply, lab.now);
    EXPECT_EQ(lab.take(), exact_stop);
    const LinkStatus status = lab.session.status(lab.now);
    EXPECT_EQ(status.reason, "the robot took the speeds 868 0 though it was stopped");
    EXPECT_FALSE(status.stop_acknowledged);
  }
}

TEST(LinkSession, ARobotThatHasRestartedWhileItStoodReportsZerosAndIsNoAlarm) {
  Lab lab;
  lab.open();
  lab.command(400, 400);
  lab.talk();
  lab.session.stop(lab.now);
  lab.talk();
  lab.robot.boot();
  for (int k = 0; k < 3; ++k) lab.pass(), lab.talk();
  EXPECT_EQ(lab.session.status(lab.now).resynchronisations, 0u);
}

TEST(LinkSession, ARobotIsStoppedWhenItsBlindDistanceIsUsedUp) {
  for (const int speed : {100, 400, 1000}) {
    Lab lab({.blind_distance = 0.02, .reply_timeout = 100.0, .command_silence = 0.0});
    lab.open();
    lab.command(speed, speed);
    lab.take();
    const double sent = lab.now, metres_per_second = speed * 1.288e-4;
    lab.pass(0.99 * 0.02 / metres_per_second);
    EXPECT_TRUE(lab.session.up()) << speed;
    EXPECT_NEAR(lab.session.blind_way(lab.now), 0.99 * 0.02, 1e-4);
    lab.pass();
    EXPECT_NEAR(lab.now - sent, 0.02 / metres_per_second, 1e-3) << "slow robots may wait longer";
    EXPECT_EQ(lab.take(), exact_stop);
    EXPECT_EQ(lab.session.status(lab.now).blind_stops, 1u);
  }
}

TEST(LinkSession, SlowingDownDoesNotMakeTheUnconfirmedWayShorterUntilItIsConfirmed) {
  Lab lab({.blind_distance = 0.05, .reply_timeout = 100.0, .command_silence = 0.0});
  lab.open();
  lab.command(1000, 1000);
  lab.take();
  lab.pass(0.1);
  lab.command(100, 100);
  lab.take();
  lab.pass(0.1);
  EXPECT_NEAR(lab.session.blind_way(lab.now), 0.2 * 0.1288, 1e-4) << "nobody says that it has slowed down";
  lab.session.received(answer(1000, 1000), lab.now);
  lab.take();
  EXPECT_NEAR(lab.session.blind_way(lab.now), 0.2 * 0.1288, 1e-4) << "since the question was sent";
  lab.pass(0.01);
  lab.session.received(answer(100, 100), lab.now);
  EXPECT_NEAR(lab.session.blind_way(lab.now), 0.01 * 0.1288, 1e-4);
  lab.pass(0.01);
  EXPECT_NEAR(lab.session.blind_way(lab.now), 0.01 * 0.1288 + 0.01 * 0.01288, 1e-5);
  lab.session.stop(lab.now);
  lab.take();
  lab.pass(1.0);
  EXPECT_GT(lab.session.blind_way(lab.now), 0.01) << "a stop that is not acknowledged";
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_EQ(lab.session.blind_way(lab.now), 0.0);
}

TEST(LinkSession, CommandSilenceStopsTheRobotOnce) {
  Lab lab;
  lab.open();
  lab.command(300, 300);
  lab.talk();
  EXPECT_NE(lab.robot.wheels(), core::WheelSpeeds{});
  lab.pass(0.099);
  EXPECT_EQ(lab.take(), Bytes{});
  lab.pass(0.002);
  EXPECT_EQ(lab.take(), exact_stop);
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_TRUE(lab.session.stop_acknowledged());
  lab.pass();
  EXPECT_EQ(lab.take(), question) << "then only heartbeats, which leave the wheels alone";
  lab.session.received(answer(300, 300), lab.now);
  lab.command(300, 300);
  lab.talk();
  lab.pass(0.11);
  EXPECT_EQ(lab.take(), exact_stop) << "and again after the next silence";
}

TEST(LinkSession, SilenceAndHeartbeatCanBeTurnedOff) {
  Lab lab({.blind_distance = 0.0, .command_silence = 0.0, .heartbeat = 0.0});
  lab.open();
  lab.command(300, 300);
  lab.talk();
  EXPECT_EQ(lab.session.deadline(), std::numeric_limits<double>::infinity());
  lab.pass(100.0);
  EXPECT_EQ(lab.take(), Bytes{});
  EXPECT_EQ(lab.session.silent_since(), std::numeric_limits<double>::infinity());
}

TEST(LinkSession, ALostReplyLeadsToTheStopAndTheCommandIsSentAgain) {
  Lab lab({.command_silence = 0.0});
  lab.open();
  lab.command(300, 300);
  lab.take();  // lost on the way
  lab.pass();
  EXPECT_EQ(lab.state(), LinkState::stale);
  EXPECT_EQ(lab.take(), exact_stop);
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_EQ(lab.take(), (Bytes{0, 0, 0, 0, 0xBC, 0x2C, 0x01, 0x2C, 0x01, 0xBB, 0xAF, 0}));
  EXPECT_NE(lab.session.answered_ticket(), lab.ticket);
}

TEST(LinkSession, AfterALostReplyAnOldCommandIsNotSentAgain) {
  Lab lab({.reply_timeout = 0.09, .command_silence = 0.1});
  lab.open();
  lab.command(300, 300);
  lab.take();
  lab.pass();
  lab.take();
  lab.pass(0.05);
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_TRUE(lab.session.up());
  EXPECT_EQ(lab.take(), Bytes{});
}

TEST(LinkSession, ALateReplyInFrontOfTheStopsAnswerIsNoTrouble) {
  Lab lab;
  lab.open();
  lab.command(300, 300);
  lab.take();
  lab.pass();
  lab.take();
  lab.session.received(Bytes{0x0D, 0x0A, 0x73, 0x0D}, lab.now);
  lab.session.received(bytes("s\r\n"), lab.now);
  EXPECT_TRUE(lab.session.up());
}

TEST(LinkSession, EmergencyStopGoesOutWithAReplyOutstanding) {
  Lab lab;
  lab.open();
  lab.command(300, 300);
  Bytes late;
  lab.robot.receive(lab.take(), late);
  lab.command(400, 400);
  lab.session.stop(lab.now);
  EXPECT_EQ(lab.session.output().size(), exact_stop.size());
  EXPECT_FALSE(lab.session.stop_acknowledged());
  lab.session.received(late, lab.now);
  lab.talk();
  EXPECT_TRUE(lab.session.stop_acknowledged());
  EXPECT_EQ(lab.robot.wheels(), core::WheelSpeeds{});
  EXPECT_TRUE(lab.session.up());
  EXPECT_EQ(lab.take(), Bytes{}) << "the command that waited is void";
}

TEST(LinkSession, EmergencyStopReplacesBytesThatNobodyTook) {
  Lab lab;
  lab.open();
  lab.command(300, 300);
  lab.session.sent(3, lab.now);  // the system took no more
  lab.session.stop(lab.now);
  EXPECT_EQ(lab.take(), exact_stop);
}

TEST(LinkSession, AfterAReconnectItStaysStoppedUntilANewCommand) {
  Lab lab;
  lab.open();
  lab.command(300, 300);
  lab.talk();
  lab.session.lost("the line hung up", lab.now);
  EXPECT_EQ(lab.state(), LinkState::down);
  EXPECT_EQ(lab.session.status(lab.now).reason, "the line hung up");
  EXPECT_FALSE(lab.session.stop_acknowledged());
  lab.command(310, 310);
  lab.open();
  EXPECT_EQ(lab.robot.wheels(), core::WheelSpeeds{});
  lab.command(200, 200);
  lab.talk();
  EXPECT_EQ(lab.robot.wheels(), (core::WheelSpeeds{200, 200}));
}

TEST(LinkSession, EncodersAreUnwrappedAndARestartAddsNothing) {
  Lab lab({.command_silence = 0.0, .heartbeat = 0.0}, core::MotorModel::epuck1);
  lab.open();
  lab.command(0, 0);
  lab.talk();
  for (int i = 0; i < 100; ++i) {
    lab.command(1000, -1000);
    lab.talk();
    lab.pass(1.0);
  }
  lab.command(0, 0);
  lab.talk();
  EXPECT_EQ(lab.session.status(lab.now).left_steps, 100000);
  EXPECT_EQ(lab.session.status(lab.now).right_steps, -100000);

  lab.robot.boot();
  lab.session.received(bytes(lab.robot.greeting()), lab.now);
  EXPECT_EQ(lab.session.status(lab.now).reason, "the robot restarted");
  EXPECT_EQ(lab.state(), LinkState::stale);
  lab.talk();
  lab.command(0, 0);
  lab.talk();
  EXPECT_EQ(lab.state(), LinkState::up);
  EXPECT_EQ(lab.session.status(lab.now).left_steps, 100000);
}

TEST(LinkSession, CountersWereReadBetweenTheQuestionAndItsAnswer) {
  Lab lab({.command_silence = 0.0, .heartbeat = 0.0});
  lab.open();
  lab.pass(1.0);
  const double asked = lab.now;
  lab.command(100, 100);
  Bytes reply;
  lab.robot.receive(lab.take(), reply);
  lab.now += 0.03;
  lab.session.received(reply, lab.now);
  const LinkStatus status = lab.session.status(lab.now);
  EXPECT_EQ(status.exchanges, 1u);
  EXPECT_DOUBLE_EQ(status.counted_since, asked);
  EXPECT_DOUBLE_EQ(status.counted_by, asked + 0.03);
}

TEST(LinkSession, AGreetingInPlaceOfAReplyIsNotTakenForEncoders) {
  Lab lab;
  lab.open();
  lab.command(100, 100);
  lab.talk();
  const std::int64_t steps = lab.session.status(lab.now).left_steps;
  lab.command(100, 100);
  lab.take();  // the robot loses power before it hears this
  lab.robot.boot();
  const std::string greeting = lab.robot.greeting();
  lab.session.received(bytes(greeting.substr(0, 30)), lab.now);
  lab.session.received(bytes(greeting.substr(30)), lab.now);
  lab.talk();
  EXPECT_EQ(lab.session.status(lab.now).reason, "the robot restarted");
  EXPECT_EQ(lab.session.status(lab.now).left_steps, steps);
  EXPECT_TRUE(lab.session.up());
}

TEST(LinkSession, UnaskedBytesLeadToTheStop) {
  Lab lab;
  lab.open();
  lab.session.received(bytes("?"), lab.now);
  EXPECT_EQ(lab.state(), LinkState::stale);
  EXPECT_EQ(lab.take(), exact_stop);
}

TEST(LinkSession, UnaskedBytesBehindTheStopsAnswerLeadToTheStopAgain) {
  Lab lab;
  lab.session.opened(lab.now);
  EXPECT_EQ(lab.take(), exact_stop);
  lab.session.received(bytes("s\r\n?"), lab.now);  // the byte would shift every answer after it
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.take(), exact_stop);
}

/// What a line makes of an exchange: which bytes come back for what was sent and what the robot answered to it.
using Line = Bytes (*)(const Bytes& sent, const Bytes& answer);
const Line as_it_is = [](const Bytes&, const Bytes& answer) { return answer; };
const Line echoing = [](const Bytes& sent, const Bytes& answer) {
  Bytes both = sent;
  both.insert(both.end(), answer.begin(), answer.end());
  return both;
};
const Line answering_twice = [](const Bytes&, const Bytes& answer) {
  Bytes both = answer;
  both.insert(both.end(), answer.begin(), answer.end());
  return both;
};

/// Commands 25 times a second. How often the robot began to drive.
int drive_over(Lab& lab, Line line, int ticks) {
  int starts = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    lab.command(300, 300);
    for (int exchange = 0; exchange < 8; ++exchange) {
      const bool stood = lab.robot.wheels() == core::WheelSpeeds{};
      Bytes answer;
      const Bytes sent = lab.take();
      lab.robot.receive(sent, answer);
      if (stood && lab.robot.wheels() != core::WheelSpeeds{}) ++starts;
      lab.session.received(line(sent, answer), lab.now);
      lab.pass(0.005);
    }
  }
  return starts;
}

TEST(LinkSession, OverALineWithAnEchoARobotStandsAndTheReasonSaysSo) {
  Lab lab;
  lab.session.opened(lab.now);
  EXPECT_EQ(drive_over(lab, echoing, 100), 0);
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.session.status(lab.now).reason,
            "the line returns what is sent to it (an echo in its cable, adapter or radio)");
  EXPECT_TRUE(lab.session.stop_acknowledged()) << "its own answers are heard all the same";

  EXPECT_EQ(drive_over(lab, as_it_is, 25), 1) << "it comes up when the echo ends";
  EXPECT_TRUE(lab.session.up());
  lab.session.stop(lab.now);
  EXPECT_LE(drive_over(lab, echoing, 25), 4) << "an echo that begins while it drives is not known at once";
  EXPECT_EQ(drive_over(lab, echoing, 100), 0);
  EXPECT_EQ(lab.robot.wheels(), core::WheelSpeeds{});
}

TEST(LinkSession, OverAnEchoWithoutARobotTheReasonIsTheEcho) {
  Lab lab;
  lab.session.opened(lab.now);
  for (int k = 0; k < 20; ++k) {
    lab.session.received(lab.take(), lab.now);
    lab.pass(0.1);
  }
  EXPECT_FALSE(lab.session.stop_acknowledged());
  EXPECT_EQ(lab.session.status(lab.now).reason,
            "the line returns what is sent to it (an echo in its cable, adapter or radio)");
}

TEST(LinkSession, ARobotThatAnswersEverythingTwiceStandsAndTheReasonSaysSo) {
  Lab lab;
  lab.session.opened(lab.now);
  EXPECT_LE(drive_over(lab, answering_twice, 25), 4) << "a byte too many may be noise";
  EXPECT_EQ(drive_over(lab, answering_twice, 100), 0);
  EXPECT_FALSE(lab.session.up());
  EXPECT_EQ(lab.robot.wheels(), core::WheelSpeeds{});
  EXPECT_EQ(lab.session.status(lab.now).reason,
            "each stop is answered more than once (does another robot hear the same line?)");
  EXPECT_EQ(drive_over(lab, as_it_is, 25), 1);
  EXPECT_TRUE(lab.session.up());
}

// Whatever goes wrong on the line, once it is quiet the link comes up and does as it is told.
TEST(LinkSession, RecoversFromAnything) {
  test::holds("after losses, noise, restarts and stops the link works again", [] {
    Lab lab({}, *rc::gen::element(core::MotorModel::epuck1, core::MotorModel::epuck2));
    lab.session.opened(lab.now);
    const int events = *rc::gen::inRange(0, 40);
    for (int i = 0; i < events; ++i) {
      switch (*rc::gen::inRange(0, 9)) {
        case 0:
          lab.command(*rc::gen::inRange(-1200, 1200), *rc::gen::inRange(-1200, 1200));
          break;
        case 1:
          lab.talk();
          break;
        case 2:
          lab.take();  // lost on the way to the robot
          break;
        case 3: {  // a part of it lost, the answer too
          const Bytes out = lab.take();
          Bytes ignored;
          lab.robot.receive(std::span(out).first(*rc::gen::inRange<std::size_t>(0, out.size() + 1)), ignored);
          break;
        }
        case 4:
          lab.session.received(*rc::gen::arbitrary<Bytes>(), lab.now);
          break;
        case 5:
          lab.robot.boot();
          lab.session.received(bytes(lab.robot.greeting()), lab.now);
          break;
        case 6:
          lab.session.stop(lab.now);
          break;
        case 7:
          lab.session.lost("test", lab.now);
          lab.session.opened(lab.now);
          break;
        default:
          lab.pass(*rc::gen::inRange(0, 300) * 0.001);
      }
      RC_ASSERT(lab.session.output().size() <= exact_stop.size());
    }
    // Every stop that was lost may cost one repetition more: its answer might have been late.
    lab.talk();
    for (int i = 0; i < events + 5; ++i) {
      lab.pass();
      lab.talk();
    }
    RC_ASSERT(lab.session.up());
    lab.command(123, -45);
    lab.talk();
    RC_ASSERT(lab.session.answered_ticket() == lab.ticket);
    RC_ASSERT(lab.robot.wheels().left == core::actual_step_rate(core::MotorModel::epuck2, 123) ||
              lab.robot.wheels().left == core::actual_step_rate(core::MotorModel::epuck1, 123));
    lab.session.stop(lab.now);
    lab.talk();
    RC_ASSERT(lab.session.stop_acknowledged());
    RC_ASSERT(lab.robot.wheels() == core::WheelSpeeds{});
  });
}

// Somebody switches robots off after a run: that is no alarm.
TEST(LinkSession, ARobotThatHadAcknowledgedItsStopStandsAfterItsLinkIsLost) {
  const auto acknowledged_after_a_loss = [](bool stands_before) {
    Lab lab;
    lab.open();
    lab.command(100, 100);
    lab.talk();
    if (stands_before) lab.session.stop(lab.now), lab.talk();
    EXPECT_EQ(lab.session.stop_acknowledged(), stands_before);
    lab.session.lost("switched off", lab.now);
    EXPECT_EQ(lab.session.status(lab.now).stop_acknowledged, lab.session.stop_acknowledged());
    const bool said = lab.session.stop_acknowledged();
    lab.session.opened(lab.now);
    EXPECT_FALSE(lab.session.stop_acknowledged()) << "who answers now has yet to stop";
    return said;
  };
  EXPECT_TRUE(acknowledged_after_a_loss(true));
  EXPECT_FALSE(acknowledged_after_a_loss(false)) << "the control: it drives on";
}

// The safety rule itself: an acknowledged stop is a robot that stands, as long as the bytes arrive unchanged.
TEST(LinkSession, AnAcknowledgedStopIsTrue) {
  test::holds("stop_acknowledged() only while the wheels stand", [] {
    Lab lab;
    lab.session.opened(lab.now);
    Bytes on_the_way_there, on_the_way_back;
    const int events = *rc::gen::inRange(0, 60);
    for (int i = 0; i < events; ++i) {
      switch (*rc::gen::inRange(0, 7)) {
        case 0:
          lab.command(*rc::gen::inRange(1, 1200), *rc::gen::inRange(-1200, 0));
          break;
        case 1: {
          const Bytes out = lab.take();
          on_the_way_there.insert(on_the_way_there.end(), out.begin(), out.end());
          break;
        }
        case 2: {
          const auto count = *rc::gen::inRange<std::size_t>(0, on_the_way_there.size() + 1);
          lab.robot.receive(std::span(on_the_way_there).first(count), on_the_way_back);
          on_the_way_there.erase(on_the_way_there.begin(),
                                 on_the_way_there.begin() + static_cast<std::ptrdiff_t>(count));
          break;
        }
        case 3: {
          const auto count = *rc::gen::inRange<std::size_t>(0, on_the_way_back.size() + 1);
          lab.session.received(std::span(on_the_way_back).first(count), lab.now);
          on_the_way_back.erase(on_the_way_back.begin(), on_the_way_back.begin() + static_cast<std::ptrdiff_t>(count));
          break;
        }
        case 4:
          lab.session.stop(lab.now);
          break;
        case 5: {  // the link breaks: part of what was on its way arrives; then there is a new one
          if (!lab.session.open()) {
            lab.session.opened(lab.now);
            break;
          }
          lab.session.lost("cut", lab.now);
          const auto count = *rc::gen::inRange<std::size_t>(0, on_the_way_there.size() + 1);
          lab.robot.receive(std::span(on_the_way_there).first(count), on_the_way_back);
          on_the_way_there.clear();
          on_the_way_back.clear();
          break;
        }
        default:
          lab.pass(*rc::gen::inRange(0, 250) * 0.001);
      }
      if (lab.session.stop_acknowledged()) RC_ASSERT(lab.robot.wheels() == core::WheelSpeeds{});
    }
  });
}

}  // namespace
}  // namespace skein::comms
