#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "comms/command_slot.h"
#include "comms/emulator/epuck_firmware.h"
#include "comms/emulator/make_firmware.h"
#include "comms/link_status.h"
#include "comms/protocol.h"
#include "comms/round_trips.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

TEST(CommandSlot, HoldsTheNewestCommandWhole) {
  test::holds("what is put is what is there", [](const std::vector<std::pair<std::int16_t, std::int16_t>>& commands) {
    CommandSlot slot;
    RC_ASSERT(slot.content().ticket == 0);
    std::uint16_t count = 0;
    for (const auto& [left, right] : commands) {
      slot.put({left, right}, 42);
      RC_ASSERT(slot.content().command == (WheelCommand{left, right}));
      RC_ASSERT(slot.content().ticket == ++count);
      RC_ASSERT(slot.content().epoch == 42);
    }
  });
}

TEST(CommandSlot, TicketsWrapPastZeroWhichMeansNone) {
  CommandSlot slot;
  for (int i = 0; i < 0xFFFF; ++i) slot.put({}, 0);
  EXPECT_EQ(slot.content().ticket, 0xFFFF);
  slot.put({}, 0);
  EXPECT_EQ(slot.content().ticket, 1);
}

TEST(CommandSlot, NeverTearsACommand) {
  CommandSlot slot;
  constexpr std::int16_t last = 20000;
  std::thread writer([&] {
    for (std::int16_t i = 1; i <= last; ++i) slot.put({i, static_cast<std::int16_t>(-i)}, 0);
  });
  std::int16_t seen = 0;
  while (seen != last) {
    const WheelCommand command = slot.content().command;
    ASSERT_EQ(command.left, -command.right);
    ASSERT_GE(command.left, seen);
    seen = command.left;
  }
  writer.join();
}

/// The crash handler and the guard read what is there.
TEST(StopHeard, AnAnswerCountsInWhateverPiecesItIsRead) {
  for (const char* const type : {"epuck1", "epuck2", "khepera4", "open"}) {
    SCOPED_TRACE(type);
    const core::RobotType& robot = *core::find_robot_type(type);
    std::unique_ptr<RobotFirmware> firmware = make_firmware(robot);
    if (!firmware) firmware = std::make_unique<EpuckFirmware>(robot.motor);
    const Protocol& protocol = *find_protocol(robot.protocol.empty() ? "asercom" : robot.protocol);
    std::vector<std::uint8_t> answer;
    firmware->receive(protocol.stop_bytes(), answer);
    ASSERT_TRUE(protocol.acknowledged(answer));
    for (std::size_t cut = 0; cut <= answer.size(); ++cut) {
      StopHeard heard;
      const std::span all(answer);
      const bool first = heard.acknowledged(protocol, all.first(cut)),
                 second = heard.acknowledged(protocol, all.subspan(cut));
      EXPECT_TRUE(first || second) << cut;
      if (first || cut == 0) continue;
      heard.forget();
      (void)heard.acknowledged(protocol, all.first(cut));
      heard.forget();
      EXPECT_EQ(heard.acknowledged(protocol, all.subspan(cut)), protocol.acknowledged(all.subspan(cut)))
          << cut << ": what came before the stop does not count";
    }
    StopHeard byte_by_byte;
    std::size_t times = 0;
    for (const std::uint8_t byte : answer) times += byte_by_byte.acknowledged(protocol, {&byte, 1}) ? 1 : 0;
    EXPECT_GE(times, 1u);
  }
}

TEST(RoundTrips, QuantilesOfTheLast256) {
  RoundTrips times;
  EXPECT_EQ(times.quantile(0.5), 0.0);
  times.add(3.0);
  EXPECT_EQ(times.quantile(0.99), 3.0);
  for (int i = 0; i < 256; ++i) times.add(100.0 + i);
  EXPECT_EQ(times.quantile(0.0), 100.0);
  EXPECT_NEAR(times.quantile(0.5), 227.5, 1.0);
  EXPECT_NEAR(times.quantile(0.99), 352.5, 1.0);
  EXPECT_EQ(times.quantile(1.0), 355.0);
}

}  // namespace
}  // namespace skein::comms
