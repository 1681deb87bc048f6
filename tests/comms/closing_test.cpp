// The end of a run while a robot is being reached: it drives on, and only this connection can stop it.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <future>
#include <thread>
#include <vector>

#include "comms/emulator/tcp_epuck.h"
#include "comms/link_supervisor.h"
#include "tests/comms/wait_until.h"
#include "tests/property.h"
#include "tests/seconds.h"

namespace skein::comms {
namespace {

using test::seconds;

sockaddr_in here(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A way to a TCP port that can be shut: then connections to it are begun and not made, as to a robot that is paged.
class Gate {
 public:
  explicit Gate(int robot) : robot_(robot), listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = here(0);
    socklen_t size = sizeof address;
    (void)::bind(listener_, reinterpret_cast<sockaddr*>(&address), size);
    ::listen(listener_, 0);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    open();
  }
  ~Gate() {
    shut_ = true;
    if (thread_.joinable()) thread_.join();
    ::close(listener_);
  }
  int port() const { return port_; }

  void open() {
    for (const int waiting : waiting_) {
      ::close(waiting);
      ::close(::accept(listener_, nullptr, nullptr));
    }
    waiting_.clear();
    shut_ = false;
    thread_ = std::thread([this] { run(); });
  }
  /// Breaks the connection, and lets others wait in the queue until it is full.
  void shut() {
    for (bool full = false; !full;) {
      const int guest = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
      const sockaddr_in address = here(port_);
      (void)::connect(guest, reinterpret_cast<const sockaddr*>(&address), sizeof address);
      pollfd made{.fd = guest, .events = POLLOUT, .revents = 0};
      full = ::poll(&made, 1, 100) == 0;
      if (full) ::close(guest);
      if (!full) waiting_.push_back(guest);
      if (waiting_.size() == 1 && thread_.joinable()) {  // from here on nobody is let in
        shut_ = true;
        thread_.join();
      }
    }
  }

 private:
  void run() {
    std::array<char, 512> bytes;
    while (!shut_) {
      pollfd arrival{.fd = listener_, .events = POLLIN, .revents = 0};
      if (::poll(&arrival, 1, 10) <= 0) continue;
      const int host = ::accept(listener_, nullptr, nullptr), robot = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const sockaddr_in address = here(robot_);
      (void)::connect(robot, reinterpret_cast<const sockaddr*>(&address), sizeof address);
      for (bool whole = true; whole && !shut_;) {
        std::array<pollfd, 2> ends{{{host, POLLIN, 0}, {robot, POLLIN, 0}}};
        if (::poll(ends.data(), ends.size(), 10) <= 0) continue;
        for (const auto& [from, to] : {std::pair(0, robot), std::pair(1, host)}) {
          if (ends[static_cast<std::size_t>(from)].revents == 0) continue;
          const ssize_t count = ::recv(ends[static_cast<std::size_t>(from)].fd, bytes.data(), bytes.size(), 0);
          whole = whole && count > 0;
          if (count > 0) (void)::send(to, bytes.data(), static_cast<std::size_t>(count), MSG_NOSIGNAL);
        }
      }
      ::close(host);
      ::close(robot);
    }
  }

  int robot_, listener_, port_ = 0;
  std::vector<int> waiting_;
  std::atomic<bool> shut_{false};
  std::thread thread_;
};

TEST(Closing, WaitsForARobotThatIsBeingReachedWhenTimeIsOut) {
  TcpEpuck robot(seconds);
  Gate gate(robot.port());
  LinkSupervisor links({{LinkKind::tcp, "127.0.0.1", gate.port(), {}, {}}},
                       {.reply_timeout = 1.0, .command_silence = 0.0, .reconnect_first = 0.01});
  const auto started = links.start(30.0);
  ASSERT_TRUE(started) << started.error();
  links.command(0, 300, 300);
  ASSERT_TRUE(links.wait_acknowledged(30.0));
  gate.shut();
  ASSERT_TRUE(test::wait_until([&] { return links.status()[0].state == LinkState::connecting; }));
  EXPECT_NE(robot.wheels(), core::WheelSpeeds{}) << "it drives on";
  auto closed = std::async(std::launch::async, [&] { return links.close(0.05); });
  EXPECT_EQ(closed.wait_for(std::chrono::milliseconds(200)), std::future_status::timeout) << "not given up";
  gate.open();
  EXPECT_TRUE(closed.get().at(0).stop_acknowledged);
  EXPECT_EQ(robot.wheels(), core::WheelSpeeds{});
}

/// A robot that drives and is not reached in the end is named, and closing ends. One that stood is known to stand.
TEST(Closing, EndsWhereTheRobotIsNotReached) {
  for (const bool drives : {true, false}) {
    TcpEpuck robot(seconds);
    Gate gate(robot.port());
    LinkSupervisor links({{LinkKind::tcp, "127.0.0.1", gate.port(), {}, {}}},
                         {.connect_timeout = 0.3, .command_silence = 0.0, .reconnect_first = 0.01});
    ASSERT_TRUE(links.start(30.0));
    if (drives) {
      links.command(0, 300, 300);
      ASSERT_TRUE(links.wait_acknowledged(30.0));
    }
    gate.shut();
    ASSERT_TRUE(test::wait_until([&] { return links.status()[0].state == LinkState::connecting; }));
    const LinkStatus status = links.close(0.05).at(0);
    EXPECT_EQ(status.state, drives ? LinkState::failed : LinkState::closed);
    EXPECT_EQ(status.stop_acknowledged, !drives);
  }
}

/// The first attempt is refused, the later ones wait in vain: why it was refused is what the operator must read.
TEST(Reaching, ARefusalIsSaidEvenWhenALaterAttemptRunsOutOfTime) {
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = here(0);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), size),
            0);  // nobody listens: connections are refused
  ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  LinkSupervisor links(
      {{LinkKind::tcp, "127.0.0.1", ntohs(address.sin_port), {}, {}}},
      {.connect_timeout = 0.2, .reconnect_first = 0.01, .reconnect_longest = 0.02, .silence_reconnect = 0.2});
  auto started = std::async(std::launch::async, [&] { return links.start(30.0); });
  ASSERT_TRUE(test::wait_until([&] { return links.status()[0].reason.find("nothing listens") != std::string::npos; }))
      << links.status()[0].reason;
  ::listen(listener, 0);
  std::vector<int> waiting;
  const auto late = [&] {  // the queue is kept full: the link's own attempts may have a place in it
    const int guest = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    (void)::connect(guest, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    waiting.push_back(guest);
    return links.status()[0].reason.find("no connection within 0.2 s") != std::string::npos;
  };
  EXPECT_TRUE(test::wait_until(late));
  const std::string reason = links.status()[0].reason;
  EXPECT_NE(reason.find("nothing listens"), std::string::npos) << reason;
  links.close(0.05);
  (void)started.get();
  for (const int guest : waiting) ::close(guest);
  ::close(listener);
}

TEST(Patience, FollowsTheRobotsThatAnAdapterHasToPage) {
  std::vector<LinkAddress> robots;
  for (int i = 0; i < 28; ++i)
    robots.push_back(
        {LinkKind::rfcomm, "10:00:E8:00:00:" + std::to_string(10 + i), 1, "hci" + std::to_string(i / 7), {}});
  EXPECT_GE(reach_patience(robots), 7 * 5.12);
  EXPECT_GE(connect_patience(robots, 0, 6.0), 7 * 5.12) << "a robot that waits in the queue is not cancelled";
  EXPECT_EQ(connect_patience({robots[0], robots[7]}, 0, 6.0), 6.0) << "an adapter each";
  EXPECT_EQ(reach_patience({{LinkKind::tcp, "192.168.1.20", 1000, {}, {}}}), 15.0) << "nobody is paged";
}

}  // namespace
}  // namespace skein::comms
