#include "comms/epuck_wifi.h"

#include <algorithm>

namespace skein::comms {
namespace {

constexpr std::uint8_t command_packet = 0x80;
constexpr std::uint8_t picture_packet = 0x01, sensor_packet = 0x02, empty_packet = 0x03;
constexpr std::uint8_t want_sensors = 0x02;  // of the request byte; 0x01 would be pictures
constexpr std::size_t picture_size = 160 * 120 * 2, sensor_size = 104;
constexpr std::size_t left_steps = 79, right_steps = 81, battery_raw = 83;  // in the sensors

int little_endian(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] | bytes[at + 1] << 8;
}

}  // namespace

std::array<std::uint8_t, wifi_command_size> wifi_command(WheelCommand command) noexcept {
  const auto low = [](std::int16_t value) { return static_cast<std::uint8_t>(value & 0xFF); };
  const auto high = [](std::int16_t value) { return static_cast<std::uint8_t>((value >> 8) & 0xFF); };
  // Settings 0: speeds rather than positions, no calibration, the robot's own obstacle avoidance off.
  return {command_packet,     want_sensors,       0, low(command.left), high(command.left),
          low(command.right), high(command.right)};
}

void WifiParser::feed(std::span<const std::uint8_t> bytes) {
  if (!garbled_) buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

std::optional<WifiPacket> WifiParser::next() {
  if (garbled_ || buffer_.empty()) return std::nullopt;
  const std::uint8_t head = buffer_.front();
  const std::size_t size = head == sensor_packet ? sensor_size : head == picture_packet ? picture_size : 0;
  if (size == 0 && head != empty_packet) {
    garbled_ = true;
    buffer_.clear();
    return std::nullopt;
  }
  if (buffer_.size() < 1 + size) return std::nullopt;
  WifiPacket packet;
  if (head == sensor_packet) {
    const auto sensors = std::span<const std::uint8_t>(buffer_).subspan(1, size);
    packet.sensors = true;
    packet.encoders = {static_cast<std::int16_t>(little_endian(sensors, left_steps)),
                       static_cast<std::int16_t>(little_endian(sensors, right_steps))};
    packet.battery = little_endian(sensors, battery_raw);
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(1 + size));
  return packet;
}

}  // namespace skein::comms
