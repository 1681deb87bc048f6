// Against message buses of its own, with a logind and a desktop that grant or refuse.
#include "comms/system_services.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/comms/fake_logind.h"
#include "tests/comms/fake_screen_saver.h"
#include "tests/eventually.h"

namespace skein::comms {
namespace {

using test::eventually;
using test::FakeLogind;
using test::FakeScreenSaver;
using test::PrivateBus;

class SleepInhibition : public testing::Test {
 protected:
  void SetUp() override {
    if (!bus.running()) GTEST_SKIP() << "there is no dbus-daemon";
  }
  PrivateBus bus;
};

TEST_F(SleepInhibition, IsAskedForWhileItIsWantedAndNoLonger) {
  const FakeLogind logind(bus);
  Inhibitor inhibitor(inhibit_sleep, "platoon");
  EXPECT_EQ(logind.asked(), 0) << "nobody drives";
  for (int times = 1; times <= 2; ++times) {
    inhibitor.hold(true);
    EXPECT_TRUE(eventually([&] { return inhibitor.held() && logind.inhibitors() == 1; }));
    EXPECT_EQ(logind.newest(), (std::vector<std::string>{"sleep:handle-lid-switch", "skein", "platoon", "block"}));
    inhibitor.hold(true);
    EXPECT_EQ(logind.asked(), times) << "once";
    inhibitor.hold(false);
    EXPECT_TRUE(eventually([&] { return !inhibitor.held() && logind.inhibitors() == 0; }));
  }
  EXPECT_EQ(inhibitor.problem(), "");
}

TEST_F(SleepInhibition, EndsWithItsOwner) {
  const FakeLogind logind(bus);
  {
    Inhibitor inhibitor(inhibit_sleep, "platoon");
    inhibitor.hold(true);
    EXPECT_TRUE(eventually([&] { return logind.inhibitors() == 1; }));
  }
  EXPECT_TRUE(eventually([&] { return logind.inhibitors() == 0; })) << "its grant may still be on the bus";
}

/// Closing the lid suspends a laptop whatever inhibits sleep, unless that is inhibited as well, which not everybody
/// may.
TEST_F(SleepInhibition, OfTheLidIsToldWhereSleepAloneIsGranted) {
  const FakeLogind logind(bus, "Access denied", "handle-lid-switch");
  Inhibitor inhibitor(inhibit_sleep, "platoon");
  inhibitor.hold(true);
  EXPECT_TRUE(eventually([&] { return inhibitor.held() && logind.inhibitors() == 1; }));
  EXPECT_EQ(logind.newest().at(0), "sleep");
  EXPECT_EQ(inhibitor.problem(), "when its lid is closed: Access denied");
}

TEST_F(SleepInhibition, IsRefusedInLogindsOwnWords) {
  const FakeLogind logind(bus, "Access denied");
  Inhibitor inhibitor(inhibit_sleep, "platoon");
  inhibitor.hold(true);
  EXPECT_TRUE(eventually([&] { return !inhibitor.problem().empty(); }));
  EXPECT_EQ(inhibitor.problem(), "Access denied");
  EXPECT_FALSE(inhibitor.held());
}

TEST_F(SleepInhibition, WithoutLogindThereIsAReason) {
  Inhibitor inhibitor(inhibit_sleep, "platoon");
  inhibitor.hold(true);
  EXPECT_TRUE(eventually([&] { return !inhibitor.problem().empty(); }));
  EXPECT_NE(inhibitor.problem().find("org.freedesktop.login1"), std::string::npos) << inhibitor.problem();
}

TEST(Inhibitor, WithoutABusTheBusIsNamed) {
  ::setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere/bus", 1);
  Inhibitor inhibitor(inhibit_sleep, "platoon");
  inhibitor.hold(true);
  EXPECT_TRUE(eventually([&] { return !inhibitor.problem().empty(); }));
  ::unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
  EXPECT_EQ(inhibitor.problem(), "the system bus, unix:path=/nowhere/bus: No such file or directory");
}

class ScreenLock : public testing::Test {
 protected:
  void SetUp() override {
    if (!bus.running()) GTEST_SKIP() << "there is no dbus-daemon";
    ::setenv("DBUS_SESSION_BUS_ADDRESS", bus.address().c_str(), 1);
  }
  void TearDown() override { ::unsetenv("DBUS_SESSION_BUS_ADDRESS"); }
  PrivateBus bus;
};

TEST_F(ScreenLock, IsInhibitedWhileItIsWantedAndNoLonger) {
  const FakeScreenSaver desktop(bus);
  Inhibitor inhibitor(inhibit_screen_lock, "platoon");
  EXPECT_EQ(desktop.inhibitors(), 0) << "nobody drives";
  for (int times = 1; times <= 2; ++times) {
    inhibitor.hold(true);
    EXPECT_TRUE(eventually([&] { return inhibitor.held() && desktop.inhibitors() == 1; }));
    EXPECT_EQ(desktop.newest(), (std::vector<std::string>{"skein", "platoon"}));
    inhibitor.hold(false);
    EXPECT_TRUE(eventually([&] { return !inhibitor.held() && desktop.inhibitors() == 0; }));
  }
  EXPECT_EQ(inhibitor.problem(), "");
}

TEST_F(ScreenLock, InhibitionEndsWithItsOwner) {
  const FakeScreenSaver desktop(bus);
  {
    Inhibitor inhibitor(inhibit_screen_lock, "platoon");
    inhibitor.hold(true);
    EXPECT_TRUE(eventually([&] { return desktop.inhibitors() == 1; }));
  }
  EXPECT_TRUE(eventually([&] { return desktop.inhibitors() == 0; }));
}

TEST_F(ScreenLock, WithoutADesktopThereIsAReason) {
  Inhibitor inhibitor(inhibit_screen_lock, "platoon");
  inhibitor.hold(true);
  EXPECT_TRUE(eventually([&] { return !inhibitor.problem().empty(); }));
  EXPECT_NE(inhibitor.problem().find("org.freedesktop.ScreenSaver"), std::string::npos) << inhibitor.problem();
  EXPECT_FALSE(inhibitor.held());
}

}  // namespace
}  // namespace skein::comms
