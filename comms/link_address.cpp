#include "comms/link_address.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <memory>

#include "comms/epuck_wifi.h"

namespace skein::comms {
namespace {

constexpr std::string_view allowed =
    R"("serial:/dev/ttyACM0", "rfcomm:10:00:E8:AA:BB:CC/1" or "tcp:192.168.1.20:1000")";

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

tl::expected<LinkAddress, std::string> parse_tcp(std::string_view text, std::string_view rest) {
  const std::size_t colon = rest.find(':');
  const std::string_view host = rest.substr(0, colon);
  const auto of_a_name = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '-' || c == '_'; };
  if (host.empty() || host.size() > 253 || !std::all_of(host.begin(), host.end(), of_a_name))
    return refuse(text, fmt::format("\"{}\" is neither an IPv4 address nor a name", host));
  LinkAddress address{LinkKind::tcp, std::string(host), wifi_port};
  if (colon != std::string_view::npos) {
    const std::string_view port = rest.substr(colon + 1);
    address.channel = read_number(port, 65535);
    if (address.channel == 0) return refuse(text, fmt::format("port \"{}\" is not a number from 1 to 65535", port));
  }
  return address;
}

}  // namespace

tl::expected<LinkAddress, std::string> parse_link_address(std::string_view text) {
  constexpr std::string_view serial = "serial:", rfcomm = "rfcomm:", tcp = "tcp:";
  LinkAddress address;
  if (text.starts_with(serial)) {
    const std::string_view path = text.substr(serial.size());
    if (!path.starts_with('/')) return refuse(text, fmt::format("\"{}\" is not a path that begins with /", path));
    address.kind = LinkKind::serial;
    address.device = std::string(path);
    return address;
  }
  if (text.starts_with(tcp)) return parse_tcp(text, text.substr(tcp.size()));
  if (!text.starts_with(rfcomm)) return refuse(text, "begins with none of \"serial:\", \"rfcomm:\", \"tcp:\"");

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

tl::expected<void, std::string> check_adapter(std::string_view adapter) {
  const bool named = adapter.size() > 3 && adapter.size() <= 6 && adapter.starts_with("hci") &&
                     std::all_of(adapter.begin() + 3, adapter.end(), [](unsigned char c) { return std::isdigit(c); });
  if (adapter.empty() || named || is_bluetooth_address(adapter)) return {};
  return tl::unexpected(fmt::format(
      "adapter \"{}\" is neither a name nor an address; allowed: \"hci0\" or \"00:1A:7D:DA:71:13\"", adapter));
}

tl::expected<LinkAddress, std::string> resolve(LinkAddress address) {
  if (address.kind != LinkKind::tcp) return address;
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_STREAM;
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
  if (address.kind == LinkKind::tcp) return fmt::format("tcp:{}:{}", address.device, address.channel);
  if (address.kind == LinkKind::serial) return "serial:" + address.device;
  return fmt::format("rfcomm:{}/{}", address.device, address.channel);
}

}  // namespace skein::comms
