#include "comms/link_address.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>

namespace skein::comms {
namespace {

constexpr std::string_view allowed = R"("serial:/dev/ttyACM0" or "rfcomm:10:00:E8:AA:BB:CC/1")";

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

}  // namespace

tl::expected<LinkAddress, std::string> parse_link_address(std::string_view text) {
  constexpr std::string_view serial = "serial:", rfcomm = "rfcomm:";
  LinkAddress address;
  if (text.starts_with(serial)) {
    const std::string_view path = text.substr(serial.size());
    if (!path.starts_with('/')) return refuse(text, fmt::format("\"{}\" is not a path that begins with /", path));
    address.kind = LinkKind::serial;
    address.device = std::string(path);
    return address;
  }
  if (!text.starts_with(rfcomm)) return refuse(text, "begins with neither \"serial:\" nor \"rfcomm:\"");

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
    const char* const end = channel.data() + channel.size();
    const auto [stop, error] = std::from_chars(channel.data(), end, address.channel);
    if (error != std::errc{} || stop != end || address.channel < 1 || address.channel > 30)
      return refuse(text, fmt::format("channel \"{}\" is not a number from 1 to 30", channel));
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

std::string to_text(const LinkAddress& address) {
  if (address.kind == LinkKind::serial) return "serial:" + address.device;
  return fmt::format("rfcomm:{}/{}", address.device, address.channel);
}

}  // namespace skein::comms
