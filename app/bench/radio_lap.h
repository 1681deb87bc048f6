#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/experiment.h"
#include "comms/emulator/radio.h"
#include "comms/emulator/radio_faults.h"
#include "core/kinematics/step_rate.h"

namespace skein::app {

/// A run over slow radios in virtual time: the control tick, the links' conversations and emulated e-pucks whose
/// messages an adapter carries, seven robots on each. It does what the program's threads do on the wall clock, without
/// threads or a wall clock: the same seed gives the same run.
struct RadioLapOptions {
  comms::RadioParameters radio;
  std::vector<comms::Fault> faults;
  std::uint64_t seed = 1;
  /// The robots' true motors, if they differ from those that the tick assumes; empty: those of the experiment.
  std::optional<core::MotorModel> motors;
  double steady = 20.0;  ///< how many seconds at the end count as steady [s]
};

struct RadioLap {
  bool all_stop = false;                         ///< a link was lost
  std::string why;                               ///< why the link was lost
  std::size_t perturbations = 0, recovered = 0;  ///< tracking within 1 cm again before the next
  double final_error = 0.0;                      ///< largest distance of a robot from its reference at the end [m]
  double min_distance = 0.0;                     ///< between two robots [m]
  double rtt_median = 0.0, rtt_p99 = 0.0, rtt_p999 = 0.0;  ///< of all robots, the largest [s]
  double written = 0.0;           ///< share of the commands that were handed over within their tick
  double late_ticks = 0.0;        ///< share of robots' ticks that were slowed or held because of the link
  std::uint64_t blind_stops = 0;  ///< times that a blind distance was used up
  std::uint64_t timeouts = 0, wrong_speeds = 0;
  /// The longest distance of a wheel since the newest confirmed question was sent, outside times in which a fault can
  /// lose or delay a stop. [m]
  double blind_way = 0.0;
  double held_up_way = 0.0;                    ///< the same, including times in which a `latency` fault delays messages
  double steady_x_e = 0.0, largest_x_e = 0.0;  ///< of the worst robot at the end: root mean square, largest [m]
};

/// As fast as a pseudo-terminal, and without interference.
constexpr comms::RadioParameters quick_radio() {
  return {.median = 0.002, .p999 = 0.005, .burst_every = 1e9, .sniff_after = 1e9};
}

RadioLap radio_lap(const Experiment& experiment, const RadioLapOptions& options);

}  // namespace skein::app
