#include "comms/transport.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <pthread.h>
#include <pty.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "comms/emulator/pty_emulator.h"
#include "comms/emulator/tcp_epuck.h"
#include "tests/comms/other_program.h"
#include "tests/comms/wait_until.h"
#include "tests/property.h"
#include "tests/seconds.h"

namespace skein::comms {
namespace {

using test::seconds;
using test::wait_until;

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

constexpr int tcp_rto_max_ms = 44;  // not in the headers of Debian 12

/// To a robot that comes back into reach nothing else brings its stop.
TEST(Transport, OverTcpWhatWasLostIsSentAgainEverySecond) {
  TcpEpuck wifi(seconds);
  const auto transport = Transport::open({LinkKind::tcp, "127.0.0.1", wifi.port(), {}, {}});
  ASSERT_TRUE(transport) << transport.error().reason;
  const auto option = [&](int name) {
    int value = -1;
    socklen_t size = sizeof value;
    return ::getsockopt(transport->wanted(false).fd, IPPROTO_TCP, name, &value, &size) == 0 ? value : -1;
  };
  if (option(tcp_rto_max_ms) < 0) GTEST_SKIP() << "Linux has this since 6.15";
  EXPECT_EQ(option(tcp_rto_max_ms), 1000);
  EXPECT_EQ(option(TCP_USER_TIMEOUT), 120'000) << "15 repetitions would be 15 s: the connection would be given up";
}

/// What reaches the robot's end while it is out of reach is dropped there by a filter. Beside it a connection that asks
/// for nothing, the control. In real time: the kernel's clock is the one that counts.
TEST(Transport, OverTcpAStopArrivesSoonAfterARobotIsBackInReach) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof here;
  ASSERT_EQ(::bind(listener, reinterpret_cast<const sockaddr*>(&here), size), 0);
  ASSERT_EQ(::listen(listener, 2), 0);
  ASSERT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&here), &size), 0);
  auto transport = Transport::open({LinkKind::tcp, "127.0.0.1", ntohs(here.sin_port), {}, {}});
  ASSERT_TRUE(transport) << transport.error().reason;
  const int reached = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
  const int plain = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(::connect(plain, reinterpret_cast<const sockaddr*>(&here), sizeof here), 0);
  const int control = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);

  const std::array<std::uint8_t, 21> stop{0x80};
  std::array<std::uint8_t, 64> heard;
  const auto carry = [&] {
    ASSERT_EQ(transport->write(stop).value(), stop.size());
    ASSERT_EQ(::send(plain, stop.data(), stop.size(), 0), static_cast<ssize_t>(stop.size()));
  };
  carry();
  for (const int end : {reached, control}) ASSERT_GT(::recv(end, heard.data(), heard.size(), 0), 0);
  EXPECT_TRUE(wait_until([&] { return transport->undelivered() == 0; })) << transport->undelivered();

  sock_filter nothing = BPF_STMT(BPF_RET | BPF_K, 0);
  const sock_fprog drop{.len = 1, .filter = &nothing};
  for (const int end : {reached, control}) {
    if (::setsockopt(end, SOL_SOCKET, SO_ATTACH_FILTER, &drop, sizeof drop) == 0) continue;
    ASSERT_EQ(errno, EPERM);
    GTEST_SKIP() << "this system grants socket filters to the superuser alone";
  }
  carry();
  std::this_thread::sleep_for(std::chrono::seconds(4));
  EXPECT_EQ(transport->undelivered(), stop.size());
  const int none = 0;
  for (const int end : {reached, control})
    ASSERT_EQ(::setsockopt(end, SOL_SOCKET, SO_DETACH_FILTER, &none, sizeof none), 0);
  const double back = seconds();
  const auto late = [&](int end) { return ::recv(end, heard.data(), heard.size(), 0) > 0 ? seconds() - back : -1.0; };
  const double robot_late = late(reached), control_late = late(control);
  std::printf("out of reach for 4 s: the stop arrives %.2f s later, without asking for it %.2f s later\n", robot_late,
              control_late);
  for (const int end : {reached, control, plain, listener}) ::close(end);
  int longest = 0;
  socklen_t width = sizeof longest;
  if (::getsockopt(transport->wanted(false).fd, IPPROTO_TCP, tcp_rto_max_ms, &longest, &width) != 0)
    GTEST_SKIP() << "Linux before 6.15 cannot be asked";
  EXPECT_LT(robot_late, control_late);
}

TEST(Transport, TriesAgainWhatMayPass) {
  for (const int error : {EBUSY, EHOSTDOWN, ECONNREFUSED, EHOSTUNREACH, ETIMEDOUT, ECONNRESET})
    EXPECT_FALSE(describe_transport_error(error, robot).permanent);
  for (const int error : {ENOENT, EACCES, ENOTTY, ENOTDIR, EISDIR, ELOOP, ENAMETOOLONG})
    EXPECT_TRUE(describe_transport_error(error, serial("/x")).permanent);
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

/// A raw pseudo-terminal: `line` is the end that a link opens, `master` the robot's.
struct Terminal {
  Terminal() {
    termios raw{};
    ::cfmakeraw(&raw);
    EXPECT_EQ(::openpty(&master, &line, nullptr, &raw, nullptr), 0);
  }
  ~Terminal() {
    ::close(line);
    hang_up();
  }
  void hang_up() {
    if (master >= 0) ::close(std::exchange(master, -1));
  }
  int master = -1, line = -1;
};

void expect_refused(const std::string& device, const std::string& sentence) {
  const auto transport = Transport::open(serial(device));
  ASSERT_FALSE(transport) << "it is opened";
  EXPECT_NE(transport.error().reason.find(sentence), std::string::npos) << transport.error().reason;
  EXPECT_FALSE(transport.error().permanent) << "it may end";
}

TEST(Transport, NamesTheProgramThatHasLockedTheLine) {
  Terminal terminal;
  const std::string device = ::ttyname(terminal.line);
  OtherProgram picocom(device, [](int line) { EXPECT_EQ(::flock(line, LOCK_EX), 0); });
  expect_refused(device, picocom.sentence());
  picocom.end();
  EXPECT_TRUE(Transport::open(serial(device)));
}

TEST(Transport, NamesTheProgramThatHasTheLineForItself) {
  Terminal terminal;
  const std::string device = ::ttyname(terminal.line);
  OtherProgram manager(device, [](int line) { EXPECT_EQ(::ioctl(line, TIOCEXCL), 0); });
  expect_refused(device, manager.sentence());
  const auto unnamed = Transport::open(serial(device), /*name_holder=*/false);
  ASSERT_FALSE(unnamed);
  EXPECT_EQ(unnamed.error().reason, "another program is using the device") << "it is not searched for";
  EXPECT_EQ(::ioctl(terminal.line, TIOCNXCL), 0);
  EXPECT_TRUE(Transport::open(serial(device)));
}

/// minicom locks by such a file alone, with the device's name as it was given.
TEST(Transport, NamesTheProgramThatHasALockFileForTheLine) {
  Terminal terminal;
  const std::string device = ::ttyname(terminal.line);
  OtherProgram minicom(device, [](int) {});
  const std::string path = fmt::format("/var/lock/LCK..skein_test_{}", ::getpid());
  const auto lock_for = [&](pid_t process) {
    std::ofstream file(path);
    file << fmt::format("{:10d}\n", process) << std::flush;
    return file.good();
  };
  if (!lock_for(minicom.process)) GTEST_SKIP() << "this user may not write to /var/lock";
  expect_refused(device, minicom.sentence());
  lock_for(::getppid());
  EXPECT_TRUE(Transport::open(serial(device))) << "a process that has other devices open";
  lock_for(minicom.process);
  minicom.end();
  EXPECT_TRUE(Transport::open(serial(device))) << "its file was left behind";
  std::filesystem::remove(path);
}

bool drive_at(int priority) {
  sched_param wanted{};
  wanted.sched_priority = priority;
  return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &wanted) == 0;
}

/// Other programs have every processor, so that the kernel's thread that passes on what terminals receive gets no time.
TEST(Transport, ATerminalHoldsUpNobodyOnABusyMachine) {
  Terminal terminal;
  auto transport = Transport::open(serial(::ttyname(terminal.line)));
  ASSERT_TRUE(transport) << transport.error().reason;
  constexpr double busy_for = 0.6, patience = 0.02;  // [s]
  double longest = 0.0;
  bool granted = false;
  std::thread([&] {
    if (granted = drive_at(21); !granted) return;
    const double until = seconds() + busy_for;
    std::vector<std::jthread> others;
    for (unsigned processor = 0; processor < std::thread::hardware_concurrency(); ++processor)
      others.emplace_back([until, processor] {
        cpu_set_t only;
        CPU_ZERO(&only);
        CPU_SET(processor, &only);
        ::pthread_setaffinity_np(::pthread_self(), sizeof only, &only);
        drive_at(1);
        while (seconds() < until) continue;
      });
    while (seconds() < until) {
      EXPECT_EQ(::write(terminal.master, "12345678", 8), 8);
      const double since = seconds();
      pollfd wanted = transport->wanted(false);
      std::array<std::uint8_t, 64> bytes{};
      if (::poll(&wanted, 1, static_cast<int>(1e3 * patience)) > 0)
        while (transport->read(bytes).value_or(0) > 0) continue;
      longest = std::max(longest, seconds() - since);
    }
  }).join();
  if (!granted) GTEST_SKIP() << "the system grants no real-time priority";
  EXPECT_LT(longest, 0.2) << "s";
}

/// More than it reads in a turn is not forgotten.
TEST(Transport, ATerminalTellsOfInputUntilAllIsRead) {
  Terminal terminal;
  auto transport = Transport::open(serial(::ttyname(terminal.line)));
  ASSERT_TRUE(transport) << transport.error().reason;
  const std::string said(100, 'x');
  ASSERT_EQ(::write(terminal.master, said.data(), said.size()), 100);
  std::array<std::uint8_t, 30> bytes{};
  std::size_t heard = 0;
  while (heard < said.size()) {
    pollfd wanted = transport->wanted(false);
    ASSERT_EQ(::poll(&wanted, 1, 30'000), 1);
    const auto count = transport->read(bytes);
    ASSERT_TRUE(count) << count.error().reason;
    heard += *count;
  }
  terminal.hang_up();
  pollfd wanted = transport->wanted(false);
  ASSERT_EQ(::poll(&wanted, 1, 30'000), 1);
  EXPECT_FALSE(transport->read(bytes)) << "it has hung up";
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
