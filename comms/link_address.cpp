#include "comms/link_address.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <memory>
#include <system_error>

#include "comms/epuck_wifi.h"
#include "core/kinematics/robot_type.h"

namespace skein::comms {
namespace {

constexpr std::string_view allowed =
    R"("serial:/dev/ttyACM0", "rfcomm:10:00:E8:AA:BB:CC/1", "tcp:192.168.1.20:1000" or "udp:192.168.1.20:2626")";
constexpr std::string_view serial = "serial:", rfcomm = "rfcomm:", tcp = "tcp:", udp = "udp:";
constexpr int open_port = 2626;

/// What robots on such a link speak as a rule.
std::string_view usual(LinkKind kind) noexcept {
  switch (kind) {
    case LinkKind::serial:
    case LinkKind::rfcomm:
      return "asercom";
    case LinkKind::tcp:
      return "wifi";
    case LinkKind::udp:
      return "open";
  }
  return {};
}

/// The protocol in front of an address, and the rest.
std::pair<std::string_view, std::string_view> split_protocol(std::string_view text) {
  const std::size_t plus = text.find('+'), colon = text.find(':');
  if (plus == std::string_view::npos || plus == 0 || colon < plus) return {{}, text};
  return {text.substr(0, plus), text.substr(plus + 1)};
}

tl::unexpected<std::string> refuse(std::string_view text, std::string_view why) {
  return tl::unexpected(fmt::format("link \"{}\": {}; allowed: {}", text, why, allowed));
}

// Six pairs of hexadecimal digits, "10:00:E8:AA:BB:CC".
bool is_bluetooth_address(std::string_view text) {
  if (text.size() != 17) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto character = static_cast<unsigned char>(text[i]);
    if (i % 3 == 2 ? character != ':' : !std::isxdigit(character)) return false;
  }
  return true;
}

// A whole number from 1 to `most`, or 0.
int read_number(std::string_view text, int most) {
  int number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc{} && stop == end && number >= 1 && number <= most ? number : 0;
}

tl::expected<LinkAddress, std::string> parse_host(std::string_view text, std::string_view rest, LinkKind kind,
                                                  int port_as_a_rule) {
  const std::size_t colon = rest.find(':');
  const std::string_view host = rest.substr(0, colon);
  const auto of_a_name = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '-' || c == '_'; };
  if (host.empty() || host.size() > 253 || !std::all_of(host.begin(), host.end(), of_a_name))
    return refuse(text, fmt::format("\"{}\" is neither an IPv4 address nor a name", host));
  LinkAddress address{kind, std::string(host), port_as_a_rule};
  if (colon != std::string_view::npos) {
    const std::string_view port = rest.substr(colon + 1);
    address.channel = read_number(port, 65535);
    if (address.channel == 0) return refuse(text, fmt::format("port \"{}\" is not a number from 1 to 65535", port));
  }
  return address;
}

tl::expected<LinkAddress, std::string> parse_plain(std::string_view text) {
  LinkAddress address;
  if (text.starts_with(serial)) {
    const std::string_view path = text.substr(serial.size());
    if (!path.starts_with('/')) return refuse(text, fmt::format("\"{}\" is not a path that begins with /", path));
    address.kind = LinkKind::serial;
    address.device = std::string(path);
    return address;
  }
  if (text.starts_with(tcp)) return parse_host(text, text.substr(tcp.size()), LinkKind::tcp, wifi_port);
  if (text.starts_with(udp)) return parse_host(text, text.substr(udp.size()), LinkKind::udp, open_port);
  if (!text.starts_with(rfcomm))
    return refuse(text, "begins with none of \"serial:\", \"rfcomm:\", \"tcp:\", \"udp:\"");

  const std::string_view rest = text.substr(rfcomm.size());
  const std::size_t slash = rest.find('/');
  const std::string_view robot = rest.substr(0, slash);
  if (!is_bluetooth_address(robot)) return refuse(text, fmt::format("\"{}\" is not a Bluetooth address", robot));
  address.kind = LinkKind::rfcomm;
  address.device = std::string(robot);
  std::transform(address.device.begin(), address.device.end(), address.device.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  address.channel = 1;
  if (slash != std::string_view::npos) {
    const std::string_view channel = rest.substr(slash + 1);
    address.channel = read_number(channel, 30);
    if (address.channel == 0) return refuse(text, fmt::format("channel \"{}\" is not a number from 1 to 30", channel));
  }
  return address;
}

}  // namespace

tl::expected<LinkAddress, std::string> parse_link_address(std::string_view text) {
  const auto [protocol, plain] = split_protocol(text);
  auto address = parse_plain(plain);
  if (!address || protocol.empty()) return address;
  std::string names = "\"asercom\", \"wifi\"";
  bool known = protocol == "asercom" || protocol == "wifi";
  for (const core::RobotType& type : core::robot_types) {
    if (type.protocol.empty()) continue;
    names += fmt::format(", \"{}\"", type.protocol);
    known = known || type.protocol == protocol;
  }
  if (!known)
    return tl::unexpected(
        fmt::format("link \"{}\": there is no protocol \"{}\"; allowed before the +: {}", text, protocol, names));
  address->protocol = protocol == usual(address->kind) ? std::string() : std::string(protocol);
  return address;
}

bool is_link_address(std::string_view text) {
  const std::string_view plain = split_protocol(text).second;
  return plain.starts_with(serial) || plain.starts_with(rfcomm) || plain.starts_with(tcp) || plain.starts_with(udp);
}

std::string_view language(const LinkAddress& address) noexcept {
  return address.protocol.empty() ? usual(address.kind) : std::string_view(address.protocol);
}

tl::expected<LinkAddress, std::string> spoken_by(LinkAddress address, std::string_view protocol) {
  const std::string_view now = language(address);
  if (protocol.empty()) {  // an e-puck's
    if (now == usual(address.kind) && address.kind != LinkKind::udp) return address;
    return tl::unexpected(fmt::format(
        "found a robot without the protocol \"{}\" of its link \"{}\"; allowed: the model of a robot with it", now,
        to_text(address)));
  }
  if (!address.protocol.empty() && now != protocol)
    return tl::unexpected(
        fmt::format("found a robot with the protocol \"{}\", allowed with the link \"{}\": one with \"{}\"", protocol,
                    to_text(address), now));
  address.protocol = protocol == usual(address.kind) ? std::string() : std::string(protocol);
  return address;
}

tl::expected<void, std::string> check_adapter(std::string_view adapter) {
  const bool named = adapter.size() > 3 && adapter.size() <= 6 && adapter.starts_with("hci") &&
                     std::all_of(adapter.begin() + 3, adapter.end(), [](unsigned char c) { return std::isdigit(c); });
  if (adapter.empty() || named || is_bluetooth_address(adapter)) return {};
  return tl::unexpected(fmt::format(
      "adapter \"{}\" is neither a name nor an address; allowed: \"hci0\" or \"00:1A:7D:DA:71:13\"", adapter));
}

tl::expected<LinkAddress, std::string> resolve(LinkAddress address) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  switch (address.kind) {
    case LinkKind::serial:
    case LinkKind::rfcomm:
      return address;
    case LinkKind::tcp:
      wanted.ai_socktype = SOCK_STREAM;
      break;
    case LinkKind::udp:
      wanted.ai_socktype = SOCK_DGRAM;
      break;
  }
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(address.device.c_str(), nullptr, &wanted, &found); error != 0)
    return tl::unexpected(fmt::format("{} is not known here: {}", address.device, ::gai_strerror(error)));
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> held(found, ::freeaddrinfo);
  char text[INET_ADDRSTRLEN] = {};
  ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr, text, sizeof text);
  address.device = text;
  return address;
}

std::string to_text(const LinkAddress& address) {
  const std::string spoken = address.protocol.empty() ? std::string() : address.protocol + '+';
  switch (address.kind) {
    case LinkKind::tcp:
      return fmt::format("{}tcp:{}:{}", spoken, address.device, address.channel);
    case LinkKind::udp:
      return fmt::format("{}udp:{}:{}", spoken, address.device, address.channel);
    case LinkKind::serial:
      return spoken + "serial:" + address.device;
    case LinkKind::rfcomm:
      break;
  }
  return fmt::format("{}rfcomm:{}/{}", spoken, address.device, address.channel);
}

std::string canonical_text(const LinkAddress& address) {
  LinkAddress one = address;
  one.protocol.clear();
  switch (one.kind) {
    case LinkKind::tcp:
    case LinkKind::udp:
    case LinkKind::rfcomm:
      std::transform(one.device.begin(), one.device.end(), one.device.begin(),
                     [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
      if (one.device == "localhost") one.device = "127.0.0.1";
      break;
    case LinkKind::serial: {
      std::error_code ignored;
      if (const auto port = std::filesystem::weakly_canonical(one.device, ignored); !ignored)
        one.device = port.string();
      break;
    }
  }
  return to_text(one);
}

}  // namespace skein::comms
