#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "comms/asercom.h"
#include "comms/battery.h"

namespace skein::comms {

enum class LinkState {
  down,           ///< not open: not tried yet, or waiting to try again (reason says why)
  connecting,     ///< a connection is being made
  synchronising,  ///< open; the stop sequence is sent, its answer awaited
  up,             ///< the robot answers
  stale,          ///< open, but a reply is overdue; the stop sequence is repeated until the robot answers
  failed,         ///< given up (reason says why): could never be opened, or closed without an acknowledged stop
  closed          ///< closed after the robot acknowledged its stop
};

/// As a word for logs and messages (core/words.h).
constexpr std::string_view word(LinkState state) noexcept {
  switch (state) {
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

/// Of a firmware's version.
inline constexpr std::size_t longest_version = 100;

/// When the newest command sent passed each of its stages, CLOCK_MONOTONIC; 0: none yet. [s]
struct CommandTimes {
  double written = 0.0;   ///< its last byte was written to the system
  double answered = 0.0;  ///< the newest answer to a command came
  WheelCommand speeds{};  ///< the speeds written then; a stop is speeds of 0 [steps/s]
  /// See LinkStatus, as of the link thread's last turn; at least LinkOptions::blind_distance while not up. [m]
  double blind_way = 0.0;
};

/// The status of one link.
struct LinkStatus {
  LinkState state = LinkState::down;
  double out_for = 0.0;     ///< for how long it has not been up, from the unanswered request on; 0: it is up [s]
  std::string reason;       ///< the newest error, as a sentence; empty: none yet
  double rtt_median = 0.0;  ///< round trip of the last 256 exchanges, 0 before the first [s]
  double rtt_p99 = 0.0;     ///< 99th percentile of the same [s]
  double rtt_p999 = 0.0;    ///< 99.9th percentile of all exchanges so far, rounded up by at most 5 % [s]
  double blind_way = 0.0;   ///< how far it may have driven since the last confirmed question was sent [m]
  std::uint64_t bytes_sent = 0;
  std::uint64_t bytes_received = 0;
  std::uint64_t exchanges = 0;           ///< requests answered
  std::uint64_t timeouts = 0;            ///< requests and stops not answered in time
  std::uint64_t resynchronisations = 0;  ///< times that an answer was missing or invalid: stopped, restarted
  std::uint64_t wrong_speeds = 0;        ///< times that the robot took speeds other than those sent
  std::uint64_t blind_stops = 0;         ///< times that LinkOptions::blind_distance was used up
  std::uint64_t reconnects = 0;          ///< times that the link came up again after a loss
  std::int64_t left_steps =
      0;  ///< unwrapped encoder, from the first reading on; a robot's restart adds nothing [steps]
  std::int64_t right_steps = 0;  ///< the same, right wheel [steps]
  /// The robot read them between these two times, CLOCK_MONOTONIC: the question was sent, the answer came.
  /// Both are the time of arrival if the counters come unsolicited. 0: never [s]
  double counted_since = 0.0, counted_by = 0.0;
  Battery battery;                 ///< newest reading; see LinkOptions::battery_period
  std::string version{};           ///< of the firmware, "Version 2.0 January 2018 GCtronic"; empty: not reported
  bool stop_acknowledged = false;  ///< the robot has acknowledged a stop and was sent no speed since: it stands
};

}  // namespace skein::comms
