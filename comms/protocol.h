#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "comms/link_address.h"
#include "comms/link_options.h"
#include "comms/link_session.h"

namespace skein::comms {

/// A protocol of robots. Links, the crash handler and the guard use only the table below.
struct Protocol {
  std::string_view name;  ///< prefix of an address whose default is another: "open+serial:/dev/ttyUSB0"
  WheelUnit unit;         ///< of commands and counters
  std::unique_ptr<LinkSession> (*make_session)(const LinkOptions&);
  /// Bytes that stop a robot whatever was sent before, at most longest_stop; static storage. Async-signal-safe.
  std::span<const std::uint8_t> (*stop_bytes)() noexcept;
  /// Whether these bytes, read after a stop was written, acknowledge it. Async-signal-safe.
  bool (*acknowledged)(std::span<const std::uint8_t> heard) noexcept;
  /// False: `acknowledged` proves only that the connection works; whether the robot stands must be asked over a new
  /// one.
  bool answers_stop = true;
  std::optional<double> charge_below{};  ///< a battery with less is low [V]; none: the robot itself reports that
};

/// Recognises the answer to a stop also if it is read in several pieces. Async-signal-safe.
class StopHeard {
 public:
  void forget() noexcept { size_ = 0; }  ///< a stop is written: what came before does not answer it
  /// bytes: what was read next, at most `most`. True: the stop is acknowledged.
  bool acknowledged(const Protocol& protocol, std::span<const std::uint8_t> bytes) noexcept;
  static constexpr std::size_t most = 512;

 private:
  std::array<std::uint8_t, 32> end_{};  // the last bytes read: longer than any acknowledgement
  std::size_t size_ = 0;
};

/// All of them.
std::span<const Protocol> protocols() noexcept;

/// The protocol with this name; null: there is none.
const Protocol* find_protocol(std::string_view name) noexcept;

/// The protocol of this link: the row of language().
const Protocol& protocol_of(const LinkAddress& address) noexcept;

}  // namespace skein::comms
