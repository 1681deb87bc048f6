#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "comms/emulator/emulated_epuck.h"
#include "comms/emulator/make_firmware.h"
#include "comms/link_session.h"
#include "tests/comms/bytes.h"

namespace skein::test {

/// Drives a robot for 10 s over a radio with these faults, then stops it: 6 s later it stands and the link is up.
inline void expect_stopped_after(const std::vector<comms::Fault>& faults, const core::RobotType& type,
                                 comms::LinkSession& session, comms::WheelCommand drive, std::uint64_t seed) {
  comms::EmulatedEpuck robot(comms::make_firmware(type), 0.0, faults, seed);
  double now = 0.0;
  session.opened(now);
  std::uint16_t ticket = 0;
  for (int tick = 0; tick < 400; ++tick) {
    if (tick < 250) session.command(drive, ++ticket, now);
    if (tick == 250) session.stop(now);
    for (int k = 0; k < 4; ++k) {
      const Bytes request(session.output().begin(), session.output().end());
      session.sent(request.size(), now);
      if (!request.empty()) robot.receive(request, now);
      now += 0.01;
      robot.advance(now);
      session.received(robot.take(), now);
      session.advance(now);
    }
  }
  EXPECT_TRUE(session.up() && session.stop_acknowledged()) << seed;
  EXPECT_EQ(robot.told(), core::WheelSpeeds{}) << seed;
}

}  // namespace skein::test
