#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/simulation/random.h"

namespace skein::comms {

/// A Bluetooth adapter's radio as a busy lab makes it. docs/emulator.md says where the numbers come from.
struct RadioParameters {
  /// Round trip of a robot that has the adapter to itself: log-normal, each direction drawn separately, with this
  /// median and this 99.9th percentile. [s]
  double median = 0.05, p999 = 0.2;
  /// A packet of up to 17 bytes and its acknowledgement: two slots of 625 us. The adapter serves one robot at a time.
  /// [s]
  double slot_pair = 0.00125;
  /// Interference: no message is carried, all wait. Mean time from one burst to the next, mean length. [s]
  double burst_every = 30.0, burst = 0.06;
  /// A link that was idle for `sniff_after` sleeps, and listens only every `sniff_interval` (sniff mode). [s]
  double sniff_after = 5.0, sniff_interval = 0.5;
};

/// One adapter and up to seven robots that share its slots. It loses nothing and keeps the order, as Bluetooth does;
/// it only delays messages. The same seed and the same messages give the same times. Not thread-safe.
class RadioAdapter {
 public:
  static constexpr std::size_t most_robots = 7;

  RadioAdapter(const RadioParameters& parameters, std::uint64_t seed);

  /// When a message of `bytes`, handed over at `now`, reaches the other end. `robot`: counts from 0 on this adapter;
  /// `to_robot`: which way. Calls must come in the order of `now`. [s]
  double arrival(std::size_t robot, bool to_robot, std::size_t bytes, double now);

 private:
  double clear_of_bursts(double at);

  RadioParameters parameters_;
  core::Random random_;
  double free_at_ = 0.0;  // the slots are taken until then
  double burst_begins_ = 0.0, burst_ends_ = 0.0;
  std::array<double, most_robots> active_at_{};              // when each link was used last
  std::array<std::array<double, 2>, most_robots> newest_{};  // arrival of the newest message each way
};

}  // namespace skein::comms
