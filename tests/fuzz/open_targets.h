#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "comms/emulator/khepera_firmware.h"
#include "comms/emulator/open_firmware.h"
#include "comms/khepera_session.h"
#include "comms/open_session.h"
#include "core/kinematics/robot_type.h"
#include "tests/fuzz/talk.h"

namespace skein::fuzz {

/// `bytes` as what hosts send to the reference robot of the open protocol. Whatever they leave behind, it drives no
/// faster than it may, one stop is understood, and its watchdog bites.
inline void to_open_robot(std::span<const std::uint8_t> bytes) {
  const core::RobotType& type = *core::find_robot_type("open");
  comms::OpenFirmware robot(type);
  std::vector<std::uint8_t> answer;
  robot.receive(comms::open_stop(), answer);
  robot.receive(bytes, answer);
  must(std::abs(robot.told().left) <= type.wheels.max_step_rate &&
       std::abs(robot.told().right) <= type.wheels.max_step_rate);
  answer.clear();
  robot.receive(comms::open_stop(), answer);
  must(robot.told() == core::WheelSpeeds{});
  must(comms::open_acknowledged(answer));
  robot.receive(bytes, answer);
  robot.advance(0.25);
  must(robot.told() == core::WheelSpeeds{});
}

/// `bytes` as what a robot says to `session`. Afterwards a robot that listens is stopped and up within a few time-outs.
inline void heard_by(comms::LinkSession& session, comms::RobotFirmware& robot, std::span<const std::uint8_t> bytes) {
  double now = 1.0;
  session.opened(now);
  session.sent(session.output().size(), now);
  for_chunks(bytes, [&](std::span<const std::uint8_t> chunk, std::size_t i) {
    now += 0.01 * chunk[0];
    session.advance(now);
    session.received(chunk, now);
    session.command({static_cast<std::int16_t>(chunk[0]), static_cast<std::int16_t>(-chunk[0])},
                    static_cast<std::uint16_t>(i + 1), now);
    must(session.output().size() <= 128);
    must(!std::isnan(session.deadline()));
    session.sent(session.output().size(), now);
  });
  stop(session, robot, now);
  must(session.up() && session.stop_acknowledged());
  must(robot.told() == core::WheelSpeeds{});
}

inline void from_open_robot(std::span<const std::uint8_t> bytes) {
  comms::OpenSession session({});
  comms::OpenFirmware robot(*core::find_robot_type("open"));
  heard_by(session, robot, bytes);
}

inline void from_khepera(std::span<const std::uint8_t> bytes) {
  comms::KheperaSession session({});
  comms::KheperaFirmware robot(*core::find_robot_type("khepera4"));
  heard_by(session, robot, bytes);
}

}  // namespace skein::fuzz
