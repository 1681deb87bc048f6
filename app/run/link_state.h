#pragma once

#include <cstdint>
#include <string_view>

namespace skein::app {

/// The state of a robot's link. A robot simulated without a link cannot lose it.
enum class LinkState : std::uint8_t {
  simulated,      ///< no link: commands and poses are passed on directly
  recorded,       ///< of a replay: nothing is connected
  down,           ///< not open: not tried yet, or waiting to try again
  connecting,     ///< a connection is being made
  synchronising,  ///< open; the stop sequence is sent, its answer awaited
  up,             ///< the robot answers
  stale,          ///< open, but a reply is overdue; the stop sequence is repeated until it answers
  failed,         ///< given up: could never be opened, or closed with the stop not acknowledged
  closed,         ///< closed after the robot acknowledged its stop
};

/// As a word for logs and tables (core/words.h).
constexpr std::string_view word(LinkState state) noexcept {
  switch (state) {
    case LinkState::simulated:
      return "simulated";
    case LinkState::recorded:
      return "recorded";
    case LinkState::down:
      return "down";
    case LinkState::connecting:
      return "connecting";
    case LinkState::synchronising:
      return "synchronising";
    case LinkState::up:
      return "up";
    case LinkState::stale:
      return "stale";
    case LinkState::failed:
      return "failed";
    case LinkState::closed:
      return "closed";
  }
  return {};
}

/// The robot can be driven: its link is up, or it needs none.
constexpr bool reachable(LinkState state) noexcept {
  return state == LinkState::up || state == LinkState::simulated;
}

}  // namespace skein::app
