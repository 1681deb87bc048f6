#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

namespace skein::comms {

/// What can be wrong with a robot, or with the radio between it and the host.
enum class FaultKind {
  latency,     ///< an answer takes longer: log-normal with `median` and `p99`, half of it each way
  loss,        ///< a share of all messages (either way, one write each) is lost
  burst,       ///< everything is lost: an interference burst, a robot out of range, a silent peer
  corruption,  ///< a share of all bytes arrives as other bytes
  disconnect,  ///< the connection breaks, and cannot be made again while the fault lasts; wheels go on
  reboot,      ///< the robot is off while the fault lasts, then greets: wheels stand, counters are 0
  stuck,       ///< the robot's parser is left in the middle of a command, as after a host has died; at once
  ring,        ///< the e-puck1's 64-byte receive ring at 115200 baud: a burst over 64 bytes overwrites its beginning
  battery,     ///< the battery is at `volts` and sags by `sag` a minute
  swapped_wheels,   ///< the command for the left wheel drives and counts the right one, and vice versa
  silent_encoders,  ///< the step counters read 0
  stall             ///< over WiFi: the robot's loop pauses, as after a mismatch on its own UART; commands wait
};

/// One fault of one robot. Times are in seconds from the start of the emulation.
struct Fault {
  FaultKind kind = FaultKind::loss;
  std::optional<std::size_t> robot = {};                      ///< counted from 0; none: every robot
  double at = 0.0;                                            ///< when it begins [s]
  double duration = std::numeric_limits<double>::infinity();  ///< how long it lasts [s]
  double median = 0.0, p99 = 0.0;                             ///< latency [s], 0 < median <= p99
  double share = 0.0;                                         ///< loss, corruption: 0 to 1
  double volts = 3.9, sag = 0.0;                              ///< battery [V], [V/min]

  double end() const noexcept { return at + duration; }
};

/// As a fault file calls it (core/words.h).
constexpr std::string_view word(FaultKind kind) noexcept {
  switch (kind) {
    case FaultKind::latency:
      return "latency";
    case FaultKind::loss:
      return "loss";
    case FaultKind::burst:
      return "burst";
    case FaultKind::corruption:
      return "corruption";
    case FaultKind::disconnect:
      return "disconnect";
    case FaultKind::reboot:
      return "reboot";
    case FaultKind::stuck:
      return "stuck";
    case FaultKind::ring:
      return "ring";
    case FaultKind::battery:
      return "battery";
    case FaultKind::swapped_wheels:
      return "swapped_wheels";
    case FaultKind::silent_encoders:
      return "silent_encoders";
    case FaultKind::stall:
      return "stall";
  }
  return {};
}

/// Faults of every kind at random: on each robot one begins every `mean_interval` seconds on average, from second 0 to
/// `duration`; none lasts beyond it. The same seed gives the same faults.
std::vector<Fault> random_faults(std::size_t robots, double duration, double mean_interval, std::uint64_t seed);

/// Those that concern a robot, in the order in which they begin.
std::vector<Fault> faults_of(const std::vector<Fault>& faults, std::size_t robot);

}  // namespace skein::comms
