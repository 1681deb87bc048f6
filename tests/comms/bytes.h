#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comms/asercom.h"
#include "comms/emulator/epuck_firmware.h"

namespace skein::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes bytes(std::string_view text) {
  return {text.begin(), text.end()};
}
inline std::string text(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

/// A host that sets speeds and reads the counters in one request: `BC l l r r AF 00`, 4 bytes back.
inline Bytes set_and_read(comms::WheelCommand command) {
  Bytes request = comms::wheel_request(command, comms::Question::none);
  request.insert(request.end() - 1, 0xAF);
  return request;
}

/// What a robot answers to `request`, as bytes.
inline Bytes ask(comms::EpuckFirmware& robot, std::span<const std::uint8_t> request) {
  Bytes reply;
  robot.receive(request, reply);
  return reply;
}
inline Bytes ask(comms::EpuckFirmware& robot, std::initializer_list<std::uint8_t> request) {
  return ask(robot, std::span<const std::uint8_t>(request.begin(), request.size()));
}
/// The same for text.
inline std::string ask(comms::EpuckFirmware& robot, std::string_view request) {
  return text(ask(robot, bytes(request)));
}

}  // namespace skein::test
