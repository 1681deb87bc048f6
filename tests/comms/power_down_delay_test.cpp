// Against a logind on a message bus of its own.
#include "comms/power_down_delay.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/comms/fake_logind.h"
#include "tests/eventually.h"

namespace skein::comms {
namespace {

using test::eventually;
using test::FakeLogind;
using test::PrivateBus;
using Announced = PowerDownDelay::Announced;

class PowerDown : public testing::Test {
 protected:
  void SetUp() override {
    if (!bus.running()) GTEST_SKIP() << "there is no dbus-daemon";
  }
  /// What `delay` hears within 5 s.
  static Announced heard(PowerDownDelay& delay) {
    Announced what = Announced::nothing;
    eventually([&] { return (what = delay.turn()) != Announced::nothing; });
    return what;
  }
  PrivateBus bus;
};

TEST_F(PowerDown, IsDelayedAsLongAsSomebodyWantsIt) {
  const FakeLogind logind(bus);
  auto delay = std::make_unique<PowerDownDelay>("platoon");
  EXPECT_TRUE(eventually([&] { return delay->turn() == Announced::nothing && logind.delays() == 1; }));
  EXPECT_EQ(logind.inhibitors(), 0) << "nobody is kept from it";
  delay.reset();
  EXPECT_TRUE(eventually([&] { return logind.delays() == 0; })) << "its grant may still be on the bus";
}

TEST_F(PowerDown, IsAnnouncedBeforehand) {
  FakeLogind logind(bus);
  PowerDownDelay delay("platoon");
  ASSERT_TRUE(eventually([&] { return delay.turn() == Announced::nothing && logind.delays() == 1; }));
  logind.announce("PrepareForShutdown", true);
  EXPECT_EQ(heard(delay), Announced::shutdown);
  EXPECT_EQ(delay.turn(), Announced::nothing) << "once";
  logind.announce("PrepareForShutdown", false);  // cancelled
  logind.announce("PrepareForSleep", true);
  EXPECT_EQ(heard(delay), Announced::suspend);
  EXPECT_EQ(logind.delays(), 1);
}

TEST_F(PowerDown, IsNeverAnnouncedWhereThereIsNoLogind) {
  PowerDownDelay delay("platoon");
  for (int i = 0; i < 100; ++i) EXPECT_EQ(delay.turn(), Announced::nothing);
}

TEST(PowerDownWithoutABus, IsNeverAnnounced) {
  auto bus = std::make_unique<PrivateBus>();
  if (!bus->running()) GTEST_SKIP() << "there is no dbus-daemon";
  PowerDownDelay delay("platoon");
  EXPECT_EQ(delay.turn(), Announced::nothing);
  bus.reset();  // it goes under the eyes of whoever listens
  for (int i = 0; i < 100; ++i) EXPECT_EQ(delay.turn(), Announced::nothing);
}

}  // namespace
}  // namespace skein::comms
