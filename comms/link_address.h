#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace skein::comms {

enum class LinkKind {
  serial,  ///< a serial line or pseudo-terminal: USB cable, /dev/rfcommN, an emulated robot
  rfcomm   ///< a Bluetooth serial connection made by this program
};

/// Where a robot is reached.
struct LinkAddress {
  LinkKind kind = LinkKind::serial;
  std::string device;  ///< serial: a path, "/dev/ttyACM0"; rfcomm: the robot's Bluetooth address, "10:00:E8:AA:BB:CC"
  int channel = 0;     ///< rfcomm: 1 to 30. e-puck1: 1, e-puck2: 2 ("UART"). serial: 0
  std::string adapter = {};  ///< rfcomm: the PC's adapter to use, "hci1" or its address; empty: the system's choice.
                             ///< One adapter holds at most 7 robots.
  std::string name = {};     ///< what messages call it, "robot 4"; empty: "robot" and its place among the links

  friend bool operator==(const LinkAddress&, const LinkAddress&) = default;
};

/// Reads "serial:/dev/ttyACM0" or "rfcomm:10:00:E8:AA:BB:CC/2" (channel 1 if not given; the address comes out in upper
/// case). The error names what was found and what is allowed.
tl::expected<LinkAddress, std::string> parse_link_address(std::string_view text);

/// Checks an adapter's name: empty, "hciN" or a Bluetooth address. The error names what was found and what is allowed.
tl::expected<void, std::string> check_adapter(std::string_view adapter);

/// The text that parse_link_address() reads (without the adapter).
std::string to_text(const LinkAddress& address);

}  // namespace skein::comms
