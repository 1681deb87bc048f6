#include "comms/asercom.h"

#include <limits>

#include "comms/emulator/epuck_firmware.h"
#include "comms/link_session.h"
#include "tests/comms/bytes.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using test::Bytes;
using test::bytes;
using ReplyKind = Reply::Kind;

std::vector<Reply> all(ReplyParser& parser) {
  std::vector<Reply> replies;
  while (auto reply = parser.next()) replies.push_back(*reply);
  return replies;
}

std::vector<Reply> lines_of(std::string_view fed) {
  ReplyParser parser;
  parser.feed(bytes(fed));
  return all(parser);
}

TEST(Asercom, BinaryRequestsByteForByte) {
  EXPECT_EQ(wheel_request(WheelCommand{100, -200}, Question::wheels),
            (Bytes{0, 0, 0, 0, 0xBC, 0x64, 0x00, 0x38, 0xFF, 0xBB, 0xAF, 0x00}));
  EXPECT_EQ(wheel_request(WheelCommand{}, Question::none), (Bytes{0, 0, 0, 0, 0xBC, 0, 0, 0, 0, 0}));
  EXPECT_EQ(wheel_request({}, Question::wheels), (Bytes{0, 0, 0, 0, 0xBB, 0xAF, 0x00}));
  EXPECT_EQ(wheel_request({}, Question::wheels_and_battery), (Bytes{0, 0, 0, 0, 0xBB, 0xAF, 0x9E, 0x00}));
  EXPECT_EQ(wheel_request(WheelCommand{}, Question::wheels_and_battery).size(), longest_request);
}

// A speed command without all of its arguments, as a host that died or a lost byte leaves it. What comes next must not
// be taken for speeds.
TEST(Asercom, ASpeedCommandThatWasBrokenOffTakesNoneOfTheNextRequest) {
  for (const core::MotorModel model : {core::MotorModel::epuck1, core::MotorModel::epuck2})
    for (const std::size_t received : {1u, 2u, 3u, 4u}) {
      const Bytes half{0xBC, 0x64, 0x00, 0x64};
      EpuckFirmware driven(model), asked(model);
      for (EpuckFirmware* robot : {&driven, &asked}) test::ask(*robot, std::span(half).first(received));
      test::ask(driven, wheel_request(WheelCommand{300, -200}, Question::none));
      EXPECT_EQ(driven.told(), (core::WheelSpeeds{300.0, -200.0})) << received;
      const Bytes answer = test::ask(asked, wheel_request({}, Question::wheels));
      const double left = received >= 2 ? 100.0 : 0.0, right = received == 4 ? 100.0 : 0.0;
      EXPECT_EQ(asked.told(), (core::WheelSpeeds{left, right})) << received << ": what was sent, else it stands";
      EXPECT_EQ(answer.size(), answer_size(Question::wheels)) << "and the robot says so";
    }
}

TEST(Asercom, CommandsThatPileUpFitTheReceiveRingOfAnEpuck1) {
  const std::size_t speeds = wheel_request(WheelCommand{}, Question::none).size();
  EXPECT_LE(longest_request + LinkSession::most_unconfirmed * speeds, 58u);
}

TEST(Asercom, StopSequenceByteForByte) {
  Bytes expected(40, 0x00);
  for (const char c : {'\r', 'S', '\r'}) expected.push_back(static_cast<std::uint8_t>(c));
  const auto stop = stop_sequence();
  EXPECT_EQ(Bytes(stop.begin(), stop.end()), expected);
}

TEST(Asercom, StopBehindAnExchangeFitsTheReceiveRingOfAnEpuck1) {
  EXPECT_LE(stop_sequence().size() + wheel_request(WheelCommand{}, Question::wheels_and_battery).size(), 58u);
}

TEST(Asercom, AsciiRequestsEndInOneLineFeed) {
  EXPECT_EQ(ascii_request('E'), "E\n");
  EXPECT_EQ(ascii_request('D', std::array{100, -200}), "D,100,-200\n");
}

TEST(Asercom, SpeedsAreClampedAndNeverWrap) {
  EXPECT_EQ(clamped(70000, -70000), (WheelCommand{1100, -1100}));
  EXPECT_EQ(clamped(std::numeric_limits<int>::max(), std::numeric_limits<int>::min()), (WheelCommand{1100, -1100}));
  EXPECT_EQ(clamped(-3, 1000), (WheelCommand{-3, 1000}));
}

TEST(Asercom, StepsAreCountedAcrossTheWrap) {
  EXPECT_EQ(steps_between(32767, -32768), 1);
  EXPECT_EQ(steps_between(-32768, 32767), -1);
  EXPECT_EQ(steps_between(-5, 7), 12);
}

TEST(Asercom, ReplyLinesAreTakenApart) {
  const ReplyLine q = parse_reply_line("q,12,-7\r\n");
  EXPECT_EQ(q.letter, 'q');
  EXPECT_EQ(q.values, (std::vector<int>{12, -7}));
  EXPECT_EQ(q.text, "q,12,-7");
  EXPECT_EQ(parse_reply_line("b,3195 (62%)").values, (std::vector<int>{3195}));
  EXPECT_EQ(parse_reply_line("e,65436,100").values, (std::vector<int>{65436, 100}));
  EXPECT_TRUE(parse_reply_line("z,Command not found").values.empty());
  EXPECT_TRUE(parse_reply_line("v,Version 1.2.2 August 2008 GCtronic").values.empty());
  EXPECT_EQ(parse_reply_line("").letter, 0);
}

TEST(ReplyParser, FindsTheStopAmongEverythingARobotSays) {
  const auto replies =
      lines_of(EpuckFirmware(core::MotorModel::epuck1).greeting() + "d\r\nz,Command not found\r\ns\r\n");
  ASSERT_EQ(replies.size(), 6u);
  EXPECT_TRUE(is_greeting(replies[0].text));
  EXPECT_TRUE(is_greeting(replies[1].text));
  EXPECT_TRUE(is_greeting(replies[2].text));
  EXPECT_EQ(replies[3].text, "d");
  EXPECT_EQ(replies[4].text, "z,Command not found");
  EXPECT_EQ(replies[5].kind, ReplyKind::stopped);
}

TEST(ReplyParser, FindsTheStopBehindALateBinaryAnswer) {
  ReplyParser parser;
  parser.feed(Bytes{0x64, 0x00, 0x38, 0xFF, 's', '\r', '\n'});
  EXPECT_EQ(parser.next().value().kind, ReplyKind::stopped);
  EXPECT_EQ(parser.pending(), 0u);
}

TEST(ReplyParser, ALateAnswerThatLooksLikeAnSIsNone) {
  ReplyParser parser;
  parser.feed(Bytes{0x00, 's', '\r', 0x00, 's', '\r', '\n'});  // encoders 0x7300, 0x000D
  const auto replies = all(parser);
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_EQ(replies[0].kind, ReplyKind::line);
  EXPECT_EQ(replies[1].kind, ReplyKind::stopped);
}

TEST(ReplyParser, LinesThatEndInSAreNoStop) {
  for (const Reply& reply : lines_of("Proximity sensors\r\nhelps\r\nz,Commands\r\n"))
    EXPECT_EQ(reply.kind, ReplyKind::line);
  EXPECT_TRUE(lines_of("s").empty());
  EXPECT_TRUE(lines_of("s\r").empty());
}

TEST(ReplyParser, EndlessNoiseIsNotCollected) {
  ReplyParser parser;
  for (int i = 0; i < 1000; ++i) {
    parser.feed(Bytes(100, 'x'));
    EXPECT_FALSE(parser.next());
  }
  EXPECT_LT(parser.pending(), 5000u);
}

TEST(ReplyParser, AnAnswerHasEightBytesOrTenAndThenNothing) {
  ReplyParser parser;
  parser.expect_answer(Question::wheels);
  parser.feed(Bytes{0x64, 0x00, 0x38, 0xFF, 0x0D, 0x0A, 0x38});
  EXPECT_FALSE(parser.next());
  parser.feed(Bytes{0xFF, 'x'});
  const Reply reply = parser.next().value();
  EXPECT_EQ(reply.kind, ReplyKind::wheels);
  EXPECT_EQ(reply.taken, (WheelCommand{100, -200}));
  EXPECT_EQ(reply.encoders, (Encoders{0x0A0D, -200}));
  EXPECT_FALSE(parser.next());
  EXPECT_EQ(parser.pending(), 1u);

  parser.clear();
  parser.expect_answer(Question::wheels_and_battery);
  parser.feed(Bytes{0, 0, 0, 0, 1, 0, 2, 0, 0x7B, 0x0C});
  EXPECT_EQ(parser.next().value().battery, 3195);
}

TEST(ReplyParser, ChunksDoNotMatter) {
  test::holds("the same replies whatever the chunks", [](const std::string& noise,
                                                         const std::vector<std::uint8_t>& cuts) {
    const Bytes fed = bytes(noise + "\r\nd\r\n" + noise + "\ns\r\ntail");
    ReplyParser whole, piecewise;
    whole.feed(fed);
    const auto expected = all(whole);
    std::vector<Reply> replies;
    std::size_t at = 0;
    for (std::size_t i = 0; at < fed.size(); ++i) {
      const std::size_t size = std::min(fed.size() - at, cuts.empty() ? 1 : 1 + std::size_t{cuts[i % cuts.size()]} % 9);
      piecewise.feed(std::span(fed).subspan(at, size));
      at += size;
      for (Reply& reply : all(piecewise)) replies.push_back(std::move(reply));
    }
    RC_ASSERT(replies.size() == expected.size());
    for (std::size_t i = 0; i < replies.size(); ++i) {
      RC_ASSERT(replies[i].kind == expected[i].kind);
      RC_ASSERT(replies[i].text == expected[i].text);
    }
    RC_ASSERT(!replies.empty() && replies.back().kind == ReplyKind::stopped);
  });
}

TEST(Asercom, SpeedsMakeTheRoundTripThroughARobot) {
  test::holds("a robot reports the speeds it was sent, binary and ASCII", [](std::int16_t left, std::int16_t right) {
    const WheelCommand command = clamped(left, right);
    EpuckFirmware robot(core::MotorModel::epuck1);
    test::ask(robot, test::set_and_read(command));
    const ReplyLine reply = parse_reply_line(test::ask(robot, ascii_request('E')));
    RC_ASSERT(reply.values == (std::vector<int>{command.left, command.right}));

    EpuckFirmware other(core::MotorModel::epuck2);
    test::ask(other, ascii_request('D', std::array<int, 2>{command.left, command.right}));
    ReplyParser parser;
    parser.expect_answer(Question::wheels);
    parser.feed(test::ask(other, wheel_request({}, Question::wheels)));
    RC_ASSERT(parser.next().value().taken == command);
  });
}

}  // namespace
}  // namespace skein::comms
