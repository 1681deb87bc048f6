#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace skein::comms {

enum class LinkKind {
  serial,  ///< a serial line or pseudo-terminal: USB cable, /dev/rfcommN, an emulated robot
  rfcomm,  ///< a Bluetooth serial connection made by this program
  tcp,     ///< an e-puck2 with the WiFi firmware, selector at 15
  udp      ///< datagrams, usually of the open protocol
};

/// The address of a robot.
struct LinkAddress {
  LinkKind kind = LinkKind::serial;
  std::string device;  ///< serial: a path, "/dev/ttyACM0"; rfcomm: the robot's Bluetooth address, "10:00:E8:AA:BB:CC";
                       ///< tcp, udp: its IPv4 address, "192.168.1.20", or a name
  int channel = 0;     ///< rfcomm: 1 to 30. e-puck1: 1, e-puck2: 2 ("UART"). tcp, udp: the port. serial: 0
  std::string adapter = {};   ///< rfcomm: the PC's adapter to use, "hci1" or its address; empty: the system's choice.
                              ///< One adapter holds at most 7 robots.
  std::string name = {};      ///< its name in messages, "robot 4"; empty: "robot" and its number among the links
  std::string protocol = {};  ///< protocol.h; empty: the default of such a link

  friend bool operator==(const LinkAddress&, const LinkAddress&) = default;
};

/// Reads "serial:/dev/ttyACM0", "rfcomm:10:00:E8:AA:BB:CC/2" (channel 1 if not given; the address comes out in upper
/// case), "tcp:192.168.1.20:1000" (port 1000 if not given) or "udp:192.168.1.20:2626" (port 2626 if not given); each
/// prefixed by the protocol and "+" unless it is the default of such a link. The error names what was found and what is
/// allowed.
tl::expected<LinkAddress, std::string> parse_link_address(std::string_view text);

/// The name of the protocol of an address: the one that it names, else the default of such a link, "asercom" (serial,
/// rfcomm), "wifi" (tcp) or "open" (udp).
std::string_view language(const LinkAddress& address) noexcept;

/// The address with the protocol of a type of robot (core/kinematics/robot_type.h; "" is an e-puck's, which depends on
/// the link). The error: the link has another one.
tl::expected<LinkAddress, std::string> spoken_by(LinkAddress address, std::string_view protocol);

/// Checks an adapter's name: empty, "hciN" or a Bluetooth address. The error names what was found and what is allowed.
tl::expected<void, std::string> check_adapter(std::string_view adapter);

/// Whether the text begins like an address.
bool is_link_address(std::string_view text);

/// Resolves the name in a tcp or udp address to an IPv4 address, and returns any other address unchanged. Blocks on the
/// system's name service: not for the link thread.
tl::expected<LinkAddress, std::string> resolve(LinkAddress address);

/// The text that parse_link_address() reads (without the adapter).
std::string to_text(const LinkAddress& address);

/// One text for every spelling of an address, whatever its protocol: two robots with the same one are one robot. Hosts
/// in lower case, the file that a link to a serial port leads to; names of hosts are not resolved.
std::string canonical_text(const LinkAddress& address);

}  // namespace skein::comms
