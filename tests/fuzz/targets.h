#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "comms/asercom.h"
#include "comms/asercom_session.h"
#include "comms/emulator/epuck_firmware.h"
#include "comms/wifi_session.h"
#include "tests/fuzz/talk.h"

namespace skein::fuzz {

/// `bytes` as what a robot says. Odd bytes decide where chunks end. The parser and the session take everything, keep a
/// bounded part of it, and afterwards a robot that listens is stopped and up within a few time-outs.
inline void replies(std::span<const std::uint8_t> bytes) {
  comms::ReplyParser parser;
  comms::AsercomSession session({});
  double now = 1.0;
  session.opened(now);
  session.sent(session.output().size(), now);
  for_chunks(bytes, [&](std::span<const std::uint8_t> chunk, std::size_t i) {
    parser.feed(chunk);
    while (parser.next()) {
    }
    must(parser.pending() <= 4096 + chunk.size());
    now += 0.01 * chunk[0];
    session.advance(now);
    session.received(chunk, now);
    session.command(comms::clamped(chunk[0], -chunk[0]), static_cast<std::uint16_t>(i + 1), now);
    must(session.output().size() <= comms::stop_sequence().size());
    must(!std::isnan(session.deadline()));
    session.sent(session.output().size(), now);
  });

  comms::EpuckFirmware robot(core::MotorModel::epuck2);
  stop(session, robot, now);
  must(session.stop_acknowledged());
  must(robot.wheels() == core::WheelSpeeds{});
}

/// `bytes` as what an e-puck2 over WiFi says, in chunks as above. A connection that cannot go on says so, keeps a
/// bounded part of what came, and the next one stops the robot.
inline void packets(std::span<const std::uint8_t> bytes) {
  comms::WifiSession session({});
  double now = 1.0;
  session.opened(now);
  session.sent(session.output().size(), now);
  for_chunks(bytes, [&](std::span<const std::uint8_t> chunk, std::size_t i) {
    now += 0.01 * chunk[0];
    session.advance(now);
    session.received(chunk, now);
    session.command(comms::clamped(chunk[0], -chunk[0]), static_cast<std::uint16_t>(i + 1), now);
    must(session.output().size() <= 2 * comms::wifi_command_size);
    must(!std::isnan(session.deadline()));
    session.sent(std::min<std::size_t>(session.output().size(), chunk[0]), now);
    if (session.garbled()) session.opened(now);
  });

  comms::EpuckFirmware robot(core::MotorModel::epuck2, comms::EpuckProgram::wifi);
  session.opened(now);
  session.stop(now);
  for (int turn = 0; turn < 20 && !session.up(); ++turn) {
    const std::vector<std::uint8_t> request(session.output().begin(), session.output().end());
    session.sent(request.size(), now);
    std::vector<std::uint8_t> answer;
    robot.receive(request, answer);
    robot.stream(answer);
    session.received(answer, now);
    now += comms::EpuckFirmware::stream_period;
    session.advance(now);
  }
  must(session.up() && session.stop_acknowledged());
  must(robot.wheels() == core::WheelSpeeds{});
}

/// `bytes` as what hosts send. Whatever they leave in the parser, one stop sequence is understood.
inline void commands(std::span<const std::uint8_t> bytes) {
  for (const core::MotorModel model : {core::MotorModel::epuck1, core::MotorModel::epuck2}) {
    comms::EpuckFirmware robot(model);
    std::vector<std::uint8_t> answer;
    robot.receive(bytes, answer);
    robot.advance(0.04);
    answer.clear();
    robot.receive(comms::stop_sequence(), answer);
    must(answer.size() >= 3 && answer.end()[-3] == 's' && answer.end()[-2] == '\r' && answer.end()[-1] == '\n');
    must(robot.wheels() == core::WheelSpeeds{});
  }
}

}  // namespace skein::fuzz
