#include "comms/protocol.h"

#include <algorithm>
#include <array>

#include "comms/asercom_session.h"
#include "comms/battery.h"
#include "comms/epuck_wifi.h"
#include "comms/khepera_session.h"
#include "comms/open_session.h"
#include "comms/wifi_session.h"

namespace skein::comms {
namespace {

template <typename Session>
std::unique_ptr<LinkSession> make(const LinkOptions& options) {
  return std::make_unique<Session>(options);
}

std::span<const std::uint8_t> wifi_stop() noexcept {
  static const auto bytes = wifi_command({});
  return bytes;
}

/// A line that ends in "s".
bool asercom_acknowledged(std::span<const std::uint8_t> heard) noexcept {
  constexpr std::array<std::uint8_t, 2> end{'s', '\r'};
  return std::search(heard.begin(), heard.end(), end.begin(), end.end()) != heard.end();
}

/// It answers nothing but what it was sent.
bool says_anything(std::span<const std::uint8_t> heard) noexcept {
  return !heard.empty();
}

constexpr std::array table{
    Protocol{.name = "asercom",
             .unit = {},
             .make_session = make<AsercomSession>,
             .stop_bytes = stop_sequence,
             .acknowledged = asercom_acknowledged,
             .charge_below = epuck_charge_below},
    Protocol{.name = "wifi",
             .unit = {},
             .make_session = make<WifiSession>,
             .stop_bytes = wifi_stop,
             .acknowledged = says_anything,
             .answers_stop = false,
             .charge_below = epuck_charge_below},
    // Its answer to a stop may be that to a line before it.
    Protocol{.name = "khepera4",
             .unit = khepera_unit,
             .make_session = make<KheperaSession>,
             .stop_bytes = khepera_stop,
             .acknowledged = khepera_acknowledged,
             .answers_stop = false,
             .charge_below = khepera_charge_below},
    Protocol{.name = "open",
             .unit = open_unit,
             .make_session = make<OpenSession>,
             .stop_bytes = open_stop,
             .acknowledged = open_acknowledged},
};

}  // namespace

bool StopHeard::acknowledged(const Protocol& protocol, std::span<const std::uint8_t> bytes) noexcept {
  std::array<std::uint8_t, most + std::tuple_size_v<decltype(end_)>> all;
  const auto come =
      std::copy_n(bytes.begin(), std::min(bytes.size(), most), std::copy_n(end_.begin(), size_, all.begin()));
  const std::span heard(all.begin(), come);
  const auto kept = heard.last(std::min(heard.size(), end_.size()));
  size_ = kept.size();
  std::copy(kept.begin(), kept.end(), end_.begin());
  return protocol.acknowledged(heard);
}

std::span<const Protocol> protocols() noexcept {
  return table;
}

const Protocol* find_protocol(std::string_view name) noexcept {
  const auto found = std::find_if(table.begin(), table.end(), [&](const Protocol& p) { return p.name == name; });
  return found == table.end() ? nullptr : &*found;
}

const Protocol& protocol_of(const LinkAddress& address) noexcept {
  const Protocol* const found = find_protocol(language(address));
  return found ? *found : table.front();
}

}  // namespace skein::comms
