#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "comms/asercom.h"

/// The e-puck2's WiFi protocol: a TCP server on the robot, port 1000, one client. Every command packet has 21 bytes and
/// is answered by one packet, in order. Sources: the manufacturer's description of the protocol, clients in the field,
/// and the robot's own parser of the same bytes behind the radio (asercom 0xF7, 0xF8; e-puck2 Asercom2.c). Pure
/// functions, any thread.
///
///     to the robot     80 | request | settings | left | right | LEDs | 4 x red, green, blue | sound
///     to the host      02 | 104 bytes of sensors           03: nothing else           01 | 38400 bytes of picture
///
/// TCP neither loses nor changes bytes, so only a new connection can resynchronise.
namespace skein::comms {

inline constexpr int wifi_port = 1000;
inline constexpr std::size_t wifi_command_size = 21;

/// Sets the speeds and asks for the sensors. The LEDs go out and the robot is silent; speeds of 0 are the stop.
std::array<std::uint8_t, wifi_command_size> wifi_command(WheelCommand command) noexcept;

/// One packet of the robot.
struct WifiPacket {
  bool sensors = false;  ///< the packet has sensor data: the following members
  Encoders encoders;
  int battery = 0;  ///< raw, see battery_of()
};

/// Splits the robot's bytes into packets, whatever chunks they arrive in.
class WifiParser {
 public:
  void feed(std::span<const std::uint8_t> bytes);
  std::optional<WifiPacket> next();                   ///< none: incomplete, or garbled
  bool garbled() const noexcept { return garbled_; }  ///< no packet begins like this: call clear()
  void clear() noexcept { buffer_.clear(), garbled_ = false; }
  std::size_t pending() const noexcept { return buffer_.size(); }

 private:
  std::vector<std::uint8_t> buffer_;
  bool garbled_ = false;
};

}  // namespace skein::comms
