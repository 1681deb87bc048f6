#include "comms/emulator/epuck_firmware.h"

#include <fmt/format.h>

#include "comms/asercom.h"
#include "tests/comms/any_request.h"
#include "tests/comms/bytes.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using core::MotorModel;
using test::ask;
using test::Bytes;
using test::bytes;

constexpr const char* welcome =
    "\f\aWELCOME to the SerCom protocol on e-Puck\r\nthe EPFL education robot type \"H\" for help\r\n";

/// A standing e-puck2's timer runs at 100 Hz: it begins with its next round.
constexpr double begin() {
  return 0.01;
}

class EveryEpuck : public testing::TestWithParam<MotorModel> {
 protected:
  EpuckFirmware robot{GetParam()};
};
INSTANTIATE_TEST_SUITE_P(Models, EveryEpuck, testing::Values(MotorModel::epuck1, MotorModel::epuck2),
                         [](const auto& model) { return model.param == MotorModel::epuck1 ? "epuck1" : "epuck2"; });

TEST_P(EveryEpuck, SetsAndReportsSpeeds) {
  EXPECT_EQ(ask(robot, "D,100,-200\n"), "d\r\n");
  EXPECT_EQ(ask(robot, "E\n"), "e,100,-200\r\n");
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, -200}));
}

TEST_P(EveryEpuck, ReportsUnclampedSpeedsWhileMotorsClamp) {
  EXPECT_EQ(ask(robot, "D,5000,-5000\n"), "d\r\n");
  EXPECT_EQ(ask(robot, "E\n"), "e,5000,-5000\r\n");
  const double fastest = core::actual_step_rate(GetParam(), core::max_step_rate(GetParam()));
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{fastest, -fastest}));
}

TEST_P(EveryEpuck, AMissingArgumentKeepsItsOldValue) {
  ask(robot, "D,100,-200\n");
  EXPECT_EQ(ask(robot, "D,300\n"), "d\r\n");
  EXPECT_EQ(ask(robot, "E\n"), "e,300,-200\r\n");
  for (const char* const malformed : {"D\n", "D,\n", "D,x,5\n", "D 1,2\n", "D;1;2\n"}) {
    EXPECT_EQ(ask(robot, malformed), "d\r\n");
    EXPECT_EQ(ask(robot, "E\n"), "e,300,-200\r\n") << malformed;
  }
  EXPECT_EQ(ask(robot, "D, 7,+8 and more\n"), "d\r\n");
  EXPECT_EQ(ask(robot, "E\n"), "e,7,8\r\n");
}

TEST_P(EveryEpuck, UnknownCommands) {
  EXPECT_EQ(ask(robot, "X\n"), "z,Command not found\r\n");
}

TEST_P(EveryEpuck, SeveralLinesInOneChunk) {
  EXPECT_EQ(ask(robot, "Q\nE\n"), "q,0,0\r\ne,0,0\r\n");
}

TEST_P(EveryEpuck, LeadingLineEndsAreSkippedAndLettersUpperCased) {
  EXPECT_EQ(ask(robot, "\r\n\n\rd,1,2\r"), "d\r\n");
  EXPECT_EQ(ask(robot, "\ne\n"), "e,1,2\r\n");
  EXPECT_EQ(ask(robot, "B\n"), "b\r\n");            // the body LED
  EXPECT_EQ(ask(robot, "b\n").substr(0, 2), "b,");  // the battery
}

TEST_P(EveryEpuck, StopStopsAndKeepsTheReportedSpeed) {
  ask(robot, "D,100,200\n");
  EXPECT_EQ(ask(robot, "S\n"), "s\r\n");
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
  EXPECT_EQ(ask(robot, "E\n"), "e,100,200\r\n");
}

TEST_P(EveryEpuck, AnswersTheRestOfTheTable) {
  EXPECT_EQ(ask(robot, "B,1\n"), "b\r\n");
  EXPECT_EQ(ask(robot, "F,2\n"), "f\r\n");
  EXPECT_EQ(ask(robot, "L,8,1\n"), "l\r\n");
  EXPECT_EQ(ask(robot, "C\n"), "c,3\r\n");
  EXPECT_EQ(parse_reply_line(ask(robot, "N\n")).values.size(), 8u);
  EXPECT_EQ(parse_reply_line(ask(robot, "A\n")).values.size(), 3u);
  EXPECT_EQ(ask(robot, "G\n").substr(0, 2), "g ");
  EXPECT_EQ(ask(robot, "g\n"), "g,0,0,0\r\n");
  EXPECT_EQ(ask(robot, "H\n").front(), '\n');
}

TEST_P(EveryEpuck, BinarySetIsSilentAndReadsAreMerged) {
  EXPECT_EQ(ask(robot, {0xBC, 0x64, 0x00, 0x38, 0xFF, 0x00}), Bytes{});
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, -200}));
  EXPECT_EQ(ask(robot, {0xAF, 0x00}), (Bytes{0, 0, 0, 0}));
  EXPECT_EQ(ask(robot, {0xBB, 0x00}), (Bytes{0x64, 0x00, 0x38, 0xFF}));
  EXPECT_EQ(ask(robot, {0xBC, 0, 0, 0, 0, 0xAF, 0xB2, 0x9F, 0x00}).size(), 4u + 16u + 6u);
  EXPECT_EQ(ask(robot, {0x9E, 0x00}).size(), 2u);
  EXPECT_EQ(ask(robot, {0x8C, 0x00}).size(), 1u);
}

TEST_P(EveryEpuck, BinarySpeedsActAsSoonAsTheirArgumentsAreIn) {
  ask(robot, {0xBC, 0x64, 0x00, 0x64});
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
  EXPECT_EQ(ask(robot, {0x00}), Bytes{});  // the high byte of the right wheel
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100}));
}

TEST_P(EveryEpuck, SetAndReadInOneWriteAnswersFourBytes) {
  EXPECT_EQ(ask(robot, test::set_and_read({500, -500})), (Bytes{0, 0, 0, 0}));
  if (GetParam() == MotorModel::epuck2) robot.advance(begin());
  robot.advance(2.0);
  EXPECT_EQ(ask(robot, test::set_and_read({0, 0})), (Bytes{0xE8, 0x03, 0x18, 0xFC}));
}

TEST_P(EveryEpuck, ACarriageReturnWithLineFeedSwallowsTheNextBinaryCommand) {
  EXPECT_EQ(ask(robot, "S\r\n"), "s\r\n");
  EXPECT_EQ(ask(robot, test::set_and_read({100, 100})), Bytes{});
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
}

TEST_P(EveryEpuck, ADanglingLineSwallowsAPlainStop) {
  ask(robot, "D,100,100\n");
  ask(robot, "D,0");
  EXPECT_EQ(ask(robot, "S\n"), "d\r\n");  // a new connection, and the parser reads "D,0S"
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{0, 100}));
  EXPECT_EQ(test::text(ask(robot, stop_sequence())), "s\r\n");
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
}

TEST_P(EveryEpuck, ThereIsNoWatchdog) {
  ask(robot, "D,100,100\n");
  robot.advance(3600.0);
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{100, 100}));
}

TEST_P(EveryEpuck, BootForgetsEverything) {
  ask(robot, "D,100,100\nD,4");
  robot.advance(1.0);
  robot.boot();
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
  EXPECT_EQ(ask(robot, "Q\nE\n"), "q,0,0\r\ne,0,0\r\n");
}

TEST_P(EveryEpuck, CountersCountWholeSteps) {
  robot.advance(begin());
  ask(robot, "D,1000,-1000\n");
  robot.advance(begin());
  const int steps = GetParam() == MotorModel::epuck2 ? 0 : 10;  // it begins at once, or with the timer's next round
  for (int i = 0; i < 25; ++i) robot.advance(0.04);
  EXPECT_EQ(ask(robot, "Q\n"), fmt::format("q,{},{}\r\n", 1000 + steps, -1000 - steps));
  ask(robot, "S\n");
  robot.advance(1.0);
  EXPECT_EQ(ask(robot, "Q\n"), fmt::format("q,{},{}\r\n", 1000 + steps, -1000 - steps));
}

TEST(Epuck1, RunsTheRatesOfItsTimer) {
  EpuckFirmware robot(MotorModel::epuck1);
  ask(robot, "D,700,910\n");
  EXPECT_NEAR(robot.wheels().left, 714.2857, 1e-4);
  EXPECT_EQ(robot.wheels().right, 1000.0);
}

TEST(Epuck1, CountersWrapAt16Bits) {
  EpuckFirmware robot(MotorModel::epuck1);
  EXPECT_EQ(ask(robot, "P,32767,-32768\n"), "p\r\n");
  EXPECT_EQ(ask(robot, "Q\n"), "q,32767,-32768\r\n");
  ask(robot, "D,1000,-1000\n");
  robot.advance(0.003);
  EXPECT_EQ(ask(robot, "Q\n"), "q,-32766,32765\r\n");
}

TEST(Epuck1, SaysWhatAnEpuck1Says) {
  EpuckFirmware robot(MotorModel::epuck1);
  EXPECT_EQ(ask(robot, "V\n"), "v,Version 1.2.2 August 2008 GCtronic\r\nHW version: FFFF\r\n");
  EXPECT_EQ(ask(robot, "b\n"), "b,1\r\n");
  EXPECT_EQ(robot.greeting(), std::string("Selector pos 3\r\n") + welcome);
  ask(robot, "D,100,100\n");
  EXPECT_EQ(ask(robot, "R\n"), "r\r\n" + robot.greeting());
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
  ask(robot, {0xBC, 0x9C, 0xFF, 0x9C, 0xFF, 0x00});
  EXPECT_EQ(ask(robot, "E\n"), "e,-100,-100\r\n");
}

TEST(Epuck2, SaysWhatAnEpuck2Says) {
  EpuckFirmware robot(MotorModel::epuck2);
  EXPECT_EQ(ask(robot, "V\n"), "v,Version 2.0 January 2018 GCtronic\r\nHW version: FFFF\r\n");
  EXPECT_EQ(ask(robot, "b\n"), "b,3195 (62%)\r\n");
  EXPECT_EQ(robot.greeting(), welcome);
  EXPECT_EQ(ask(robot, "R\n"), "");
  EXPECT_EQ(ask(robot, {0xF8, 0x00}).size(), 103u);
}

TEST(Epuck2, ReportsBinaryNegativesWithoutTheirSignInAscii) {
  EpuckFirmware robot(MotorModel::epuck2);
  ask(robot, {0xBC, 0x9C, 0xFF, 0x64, 0x00, 0x00});
  EXPECT_EQ(ask(robot, "E\n"), "e,65436,100\r\n");
  EXPECT_EQ(robot.wheels(), (core::WheelSpeeds{-100, 100}));
}

TEST(Epuck2, CountersHave32Bits) {
  EpuckFirmware robot(MotorModel::epuck2);
  ask(robot, "D,1000,-1000\n");
  robot.advance(begin());
  robot.advance(40.0);
  EXPECT_EQ(ask(robot, "Q\n"), "q,40000,-40000\r\n");
  EXPECT_EQ(ask(robot, {0xAF, 0x00}), (Bytes{0x40, 0x9C, 0xC0, 0x63}));
}

TEST_P(EveryEpuck, TheStopSequenceStopsItFromEveryState) {
  const MotorModel model = GetParam();
  test::holds("after anything at all, cut off anywhere, the stop sequence stops and says \"s\"", [model] {
    EpuckFirmware stuck(model);
    Bytes stream;
    for (const Bytes& request : *rc::gen::container<std::vector<Bytes>>(test::any_request()))
      stream.insert(stream.end(), request.begin(), request.end());
    stream.resize(*rc::gen::inRange<std::size_t>(0, stream.size() + 1));
    Bytes ignored;
    stuck.receive(stream, ignored);

    const Bytes answer = ask(stuck, stop_sequence());
    RC_ASSERT(stuck.wheels() == core::WheelSpeeds{});
    RC_ASSERT(test::text(answer).ends_with("s\r\n"));
    // A long binary answer in front hides the line; then the repetition's is in the clear.
    ReplyParser parser;
    parser.feed(answer);
    parser.feed(ask(stuck, stop_sequence()));
    bool stopped = false;
    while (const auto reply = parser.next()) stopped = reply->kind == Reply::Kind::stopped;
    RC_ASSERT(stopped);  // and it is the last thing said
    RC_ASSERT(parser.pending() == 0u);
    // The parser is at the beginning again: the very next exchange works.
    RC_ASSERT(ask(stuck, test::set_and_read({100, 100})).size() == 4u);
    RC_ASSERT(stuck.wheels() == (core::WheelSpeeds{100, 100}));
  });
}

TEST_P(EveryEpuck, ChunksDoNotMatter) {
  const MotorModel model = GetParam();
  test::holds("byte by byte is the same as all at once", [model](const std::vector<bool>& cuts) {
    EpuckFirmware whole(model), piecewise(model);
    Bytes stream;
    for (const Bytes& request : *rc::gen::container<std::vector<Bytes>>(test::any_request()))
      stream.insert(stream.end(), request.begin(), request.end());
    Bytes expected, reply, chunk;
    whole.receive(stream, expected);
    for (std::size_t i = 0; i < stream.size(); ++i) {
      chunk.push_back(stream[i]);
      if (cuts.empty() || cuts[i % cuts.size()]) {
        piecewise.receive(chunk, reply);
        chunk.clear();
      }
    }
    piecewise.receive(chunk, reply);
    RC_ASSERT(reply == expected);
    RC_ASSERT(piecewise.wheels() == whole.wheels());
  });
}

}  // namespace
}  // namespace skein::comms
