#include "comms/transport.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "comms/emulator/pty_emulator.h"
#include "tests/property.h"

namespace skein::comms {
namespace {

LinkAddress serial(const std::string& device) {
  return {LinkKind::serial, device, 0, ""};
}
const LinkAddress robot{LinkKind::rfcomm, "10:00:E8:AA:BB:CC", 2, "hci1"};

TEST(Transport, SaysWhatAnOperatorUnderstands) {
  const auto says = [](int error, const LinkAddress& address, const char* what) {
    const std::string reason = describe_transport_error(error, address).reason;
    EXPECT_NE(reason.find(what), std::string::npos) << reason;
  };
  says(ECONNREFUSED, robot, "channel 2");
  says(EHOSTDOWN, robot, "switched on");
  says(EBUSY, robot, "busy");
  says(EHOSTUNREACH, robot, "adapter");
  says(EADDRNOTAVAIL, robot, "hci1");
  says(ECONNRESET, robot, "closed the connection");
  says(ECONNABORTED, robot, "unplugged");
  says(EACCES, serial("/dev/ttyACM0"), "/dev/ttyACM0");
  says(ENOENT, serial("/dev/ttyACM0"), "/dev/ttyACM0");
  says(EWOULDBLOCK, serial("/dev/ttyACM0"), "another program");
}

TEST(Transport, TriesAgainWhatMayPass) {
  for (const int error : {EBUSY, EHOSTDOWN, ECONNREFUSED, EHOSTUNREACH, ETIMEDOUT, ECONNRESET})
    EXPECT_FALSE(describe_transport_error(error, robot).permanent);
  for (const int error : {ENOENT, EACCES, ENOTTY}) EXPECT_TRUE(describe_transport_error(error, serial("/x")).permanent);
}

TEST(Transport, RefusesWhatIsNoSerialLine) {
  const auto missing = Transport::open(serial("/nowhere/ttyACM0"));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().reason.find("there is no device /nowhere/ttyACM0"), std::string::npos);
  const auto file = Transport::open(serial("/dev/null"));
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().reason.find("not a serial line"), std::string::npos);
  EXPECT_TRUE(file.error().permanent);
}

TEST(Transport, LetsNobodyElseOpenTheSameLine) {
  PtyEmulator robots({core::MotorModel::epuck2}, nullptr, [] { return 0.0; });
  {
    const auto first = Transport::open(serial(robots.device(0)));
    ASSERT_TRUE(first) << first.error().reason;
    const auto second = Transport::open(serial(robots.device(0)));
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().reason.find("another program"), std::string::npos) << second.error().reason;
    EXPECT_FALSE(second.error().permanent);
  }
  EXPECT_TRUE(Transport::open(serial(robots.device(0))));
}

TEST(Transport, BluetoothWithoutAnAdapterIsASentence) {
  const int probe = ::socket(31 /* AF_BLUETOOTH */, SOCK_STREAM | SOCK_CLOEXEC, 3 /* RFCOMM */);
  if (probe >= 0) {
    ::close(probe);
    GTEST_SKIP() << "this machine has Bluetooth";
  }
  LinkAddress address = robot;
  const auto transport = Transport::open(address);
  ASSERT_FALSE(transport);
  EXPECT_NE(transport.error().reason.find("Bluetooth"), std::string::npos) << transport.error().reason;
}

}  // namespace
}  // namespace skein::comms
