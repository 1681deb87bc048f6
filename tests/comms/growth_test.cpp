// Links that break and come back again and again leave no thread, descriptor or memory behind.
#include <chrono>

#include "comms/emulator/pty_emulator.h"
#include "comms/emulator/tcp_epuck.h"
#include "comms/link_supervisor.h"
#include "tests/comms/held.h"
#include "tests/comms/wait_until.h"
#include "tests/property.h"
#include "tests/seconds.h"

namespace skein::comms {
namespace {

using test::seconds;

TEST(Growth, BrokenLinksLeaveNothingBehind) {
  PtyEmulator robots({core::MotorModel::epuck1, core::MotorModel::epuck2}, nullptr, seconds);
  TcpEpuck wifi(seconds);
  const LinkOptions hasty{.reply_timeout = 0.05,
                          .command_silence = 0.0,
                          .heartbeat = 0.02,
                          .reconnect_first = 0.002,
                          .reconnect_longest = 0.01};
  LinkSupervisor links({{LinkKind::serial, robots.device(0), 0, ""},
                        {LinkKind::serial, robots.device(1), 0, ""},
                        {LinkKind::tcp, "127.0.0.1", wifi.port(), ""}},
                       hasty);
  ASSERT_TRUE(links.start(10.0));
  std::uint64_t breaks = 0;
  const auto all_came_back = [&] {
    return test::wait_until([&] {
      for (const LinkStatus& link : links.status())
        if (link.reconnects < breaks || link.state != LinkState::up) return false;
      return true;
    });
  };
  const auto rounds = [&](int count) {
    for (int i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < links.size(); ++k) links.command(k, 100 + i, -100);
      robots.hang_up(0);
      robots.hang_up(1);
      if (i % 8 == 0) wifi.reboot();  // its firmware has ten sockets
      wifi.hang_up();
      ++breaks;
      ASSERT_TRUE(all_came_back()) << "round " << i;
    }
  };
  rounds(20);  // buffers grow to their sizes
  const test::Held before;
  rounds(60);
  const test::Held after;
  EXPECT_EQ(after.descriptors, before.descriptors);
  EXPECT_EQ(after.threads, before.threads);
  EXPECT_LE(after.memory, before.memory + 16 * 1024) << "60 rounds, 180 connections";
  for (const LinkStatus& link : links.close(5.0)) EXPECT_TRUE(link.stop_acknowledged);
}

}  // namespace
}  // namespace skein::comms
