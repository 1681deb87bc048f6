#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "comms/link_address.h"
#include "comms/link_options.h"
#include "comms/link_session.h"

namespace skein::comms {

/// A language that robots speak. The table below is all there is to it for links, the crash handler and the guard.
struct Protocol {
  std::string_view name;  ///< in front of an address that would be read otherwise: "open+serial:/dev/ttyUSB0"
  WheelUnit unit;         ///< of commands and counters
  std::unique_ptr<LinkSession> (*make_session)(const LinkOptions&);
  /// What stops a robot whatever was sent before, at most longest_stop bytes that live for ever. Async-signal-safe.
  std::span<const std::uint8_t> (*stop_bytes)() noexcept;
  /// Whether these bytes, read after a stop was written, say that the robot has taken it. Async-signal-safe.
  bool (*acknowledged)(std::span<const std::uint8_t> heard) noexcept;
  /// False: what `acknowledged` sees says only that the connection lives; whether the robot stands is seen over a new
  /// one.
  bool answers_stop = true;
};

/// All of them.
std::span<const Protocol> protocols() noexcept;

/// The one of this name; null: there is none.
const Protocol* find_protocol(std::string_view name) noexcept;

/// What is spoken on this link: the row of language().
const Protocol& protocol_of(const LinkAddress& address) noexcept;

}  // namespace skein::comms
