#include <thread>

#include "comms/command_slot.h"
#include "comms/link_status.h"
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
