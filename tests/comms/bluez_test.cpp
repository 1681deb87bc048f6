#include "comms/bluez.h"

#include "tests/comms/fake_bluez.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

using test::FakeBluez;
using test::FakeDevice;
using test::PrivateBus;

const FakeDevice first{.name = "e-puck_1234", .address = "10:00:E8:AA:BB:01", .pin = "1234"};
const FakeDevice second{.name = "e-puck2_04567", .address = "30:AE:A4:AA:BB:02"};
const FakeDevice telephone{.name = "Anna's e-puck_1", .address = "11:22:33:44:55:66"};
constexpr double short_scan = 0.1;  // the fake daemon hears everybody at once [s]

TEST(BluetoothRobots, NamesTellModelPinAndChannel) {
  for (const char* name : {"e-puck_1234", "e-puck_0007", "e-puck2_04567"}) EXPECT_TRUE(is_epuck_name(name)) << name;
  for (const char* name : {"", "e-puck", "e-puck_", "e-puck2_", "e-puck_12a4", "my e-puck_1234", "e-puck3_1234"})
    EXPECT_FALSE(is_epuck_name(name)) << name;
  EXPECT_EQ(pairing_pin("e-puck_0123"), "0123");
  EXPECT_EQ(pairing_pin("e-puck2_04567"), "0000");
  const BluetoothRobot one{"e-puck_1234", "10:00:E8:AA:BB:01", "hci0"},
      two{"e-puck2_04567", "30:AE:A4:AA:BB:02", "hci1"};
  EXPECT_EQ(to_text(one.link()), "rfcomm:10:00:E8:AA:BB:01/1");
  EXPECT_EQ(to_text(two.link()), "rfcomm:30:AE:A4:AA:BB:02/2");
  EXPECT_EQ(two.link().adapter, "hci1");
  EXPECT_EQ(one.model(), core::MotorModel::epuck1);
  EXPECT_EQ(two.model(), core::MotorModel::epuck2);
}

/// A bus with dbus-daemon; without that program there is nothing to test against.
class Bluez : public testing::Test {
 protected:
  void SetUp() override {
    if (!bus.running()) GTEST_SKIP() << "there is no dbus-daemon";
  }
  static std::string scan_error(const ScanOptions& options = {.seconds = short_scan}) {
    const auto robots = scan_robots(options);
    return robots ? "found " + std::to_string(robots->size()) : robots.error();
  }
  static std::string pair_error(const std::string& robot) {
    const auto paired = pair_robot({.robot = robot, .timeout = 1.0});
    return paired ? "paired" : paired.error();
  }
  PrivateBus bus;
};

TEST_F(Bluez, AScanFindsRobotsAndNothingElse) {
  FakeBluez bluez(bus, {{}}, {second, telephone, first});
  const auto robots = scan_robots({.seconds = short_scan});
  ASSERT_TRUE(robots) << robots.error();
  ASSERT_EQ(robots->size(), 2u);
  EXPECT_EQ((*robots)[0].name, "e-puck2_04567");
  EXPECT_EQ((*robots)[1].name, "e-puck_1234");
  EXPECT_EQ((*robots)[1].address, first.address);
  EXPECT_EQ((*robots)[1].adapter, "hci0");
  EXPECT_FALSE((*robots)[1].paired);
  EXPECT_EQ(bluez.discoveries(), 0) << "a scan ends the discovery that it began";
}

TEST_F(Bluez, RobotsAreSpreadOverTheAdaptersThatHearThem) {
  std::vector<FakeDevice> devices;
  for (const char* adapter : {"hci0", "hci1"})
    for (FakeDevice device : {first, second}) {
      device.adapter = adapter;
      device.paired = device.address == second.address && device.adapter == "hci1";
      devices.push_back(device);
    }
  FakeBluez bluez(bus, {{"hci0"}, {"hci1", "00:1A:7D:DA:71:14"}}, devices);
  const auto both = scan_robots({.seconds = short_scan});
  ASSERT_TRUE(both) << both.error();
  ASSERT_EQ(both->size(), 2u);
  EXPECT_EQ((*both)[0].adapter, "hci1") << "where it is paired";
  EXPECT_TRUE((*both)[0].paired);
  EXPECT_EQ((*both)[1].adapter, "hci0") << "where there are fewer robots";
  const auto one = scan_robots({.adapter = "00:1a:7d:da:71:14", .seconds = short_scan});
  ASSERT_TRUE(one) << one.error();
  for (const BluetoothRobot& robot : *one) EXPECT_EQ(robot.adapter, "hci1");
}

TEST_F(Bluez, SaysWhatIsMissing) {
  EXPECT_NE(scan_error().find("systemctl start bluetooth"), std::string::npos) << scan_error();
  {
    FakeBluez bluez(bus, {}, {});
    EXPECT_NE(scan_error().find("no Bluetooth adapter"), std::string::npos) << scan_error();
  }
  FakeBluez bluez(bus, {{.powered = false}, {"hci1", "00:1A:7D:DA:71:14"}}, {});
  EXPECT_NE(scan_error({.adapter = "hci0", .seconds = short_scan}).find("hci0 is off"), std::string::npos);
  const std::string none = scan_error({.adapter = "hci7", .seconds = short_scan});
  EXPECT_NE(none.find("no adapter hci7; there are: hci0, hci1"), std::string::npos) << none;
  EXPECT_EQ(scan_error({.adapter = "hci1", .seconds = short_scan}), "found 0");
}

TEST(BluezWithoutBus, IsASentence) {
  ::setenv("DBUS_SYSTEM_BUS_ADDRESS", "unix:path=/nowhere/bus", 1);
  const auto robots = scan_robots({.seconds = short_scan});
  ::unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
  ASSERT_FALSE(robots);
  EXPECT_NE(robots.error().find("no D-Bus system bus"), std::string::npos) << robots.error();
}

TEST_F(Bluez, AnEpuck1IsToldItsNumberAndAnEpuck2PairsByItself) {
  FakeBluez bluez(bus, {{}}, {first, second});
  const auto one = pair_robot({.robot = "e-puck_1234", .timeout = 5.0});
  ASSERT_TRUE(one) << one.error();
  EXPECT_TRUE(one->paired);
  EXPECT_EQ(one->address, first.address);
  EXPECT_EQ(pair_error("30:ae:a4:aa:bb:02"), "paired");
  EXPECT_EQ(pair_error("e-puck_1234"), "paired") << "as it was";
  EXPECT_EQ(bluez.discoveries(), 0);
  EXPECT_EQ(bluez.agents(), 0);
}

TEST_F(Bluez, PairingThatFailsSaysWhy) {
  FakeDevice wrong_pin = first, silent = second;
  wrong_pin.pin = "9999";
  silent.answers = false;
  FakeDevice unwilling{.name = "e-puck2_04568", .address = "30:AE:A4:AA:BB:03", .refuses = true};
  FakeBluez bluez(bus, {{}}, {wrong_pin, silent, unwilling, telephone});
  EXPECT_NE(pair_error("e-puck2_04568").find("it requested no PIN"), std::string::npos) << pair_error("e-puck2_04568");
  EXPECT_NE(pair_error("e-puck_1234").find("refuses the PIN"), std::string::npos) << pair_error("e-puck_1234");
  EXPECT_NE(pair_error(second.address).find("does not answer"), std::string::npos) << pair_error(second.address);
  EXPECT_NE(pair_error(telephone.address).find("not that of an e-puck"), std::string::npos);
  EXPECT_NE(pair_error("e-puck_4321").find("was found"), std::string::npos) << pair_error("e-puck_4321");
  EXPECT_EQ(bluez.agents(), 0);
}

TEST_F(Bluez, AScanEndsWhenItIsTold) {
  FakeBluez bluez(bus, {{}}, {first});
  int asked = 0;
  const auto robots = scan_robots({.seconds = 3600.0, .keep_on = [&asked] { return ++asked < 3; }});
  ASSERT_TRUE(robots) << robots.error();
  EXPECT_EQ(robots->size(), 1u);
}

}  // namespace
}  // namespace skein::comms
