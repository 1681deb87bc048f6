#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <optional>

namespace skein::vision::detail {

/// Converts the time stamps of a camera's own clock to the host's clock. Each stamp comes with the arrival time of its
/// frame's first packet. No packet arrives before it is sent, so the smallest difference (arrival minus stamp) of the
/// last two seconds contains the least network delay. If the camera's clock could be read, this difference minus the
/// offset of the clocks is the delay from stamp to packet, and is subtracted. Crystals that differ by 50 ppm cost 0.1
/// ms. One frame that arrives late, because the machine is busy, says nothing about the clock: arrival times replace
/// its stamps only after four frames in a row have disagreed with it. All times in s.
class DeviceClock {
 public:
  /// `offset`: the host's clock minus the camera's, as read; none: the camera's clock cannot be read.
  explicit DeviceClock(std::optional<double> offset = {}) : read_(offset) {}

  /// Takes a frame's stamp and returns a time on the host's clock: if the camera's clock was read, the time of the
  /// stamp; otherwise the time at which the first packet would have arrived over an idle network. Never later than
  /// `arrived`.
  double host(double stamp, double arrived) {
    const double difference = arrived - stamp;
    if (!buckets_.empty() && stamp < last_stamp_) restart();
    if (buckets_.empty()) first_ = Pair{stamp, arrived};
    last_stamp_ = stamp;
    update(arrived, difference);
    const double passed = arrived - first_.arrived;
    recent_[frames_++ % recent_.size()] = difference;
    const double change = *std::min_element(recent_.begin(), recent_.end()) - (first_.arrived - first_.stamp);
    usable_ = std::abs(change) <= same_rate * passed + allowed_jitter;
    if (!usable_) return arrived;
    if (!read_) return std::min(arrived, stamp + least());
    // The first second: the delay is still being learnt, and clocks have not drifted yet.
    if (!delay_ && passed >= learning) delay_ = std::max(0.0, least() - *read_);
    return std::min(arrived, stamp + (delay_ ? least() - *delay_ : *read_));
  }

  /// False: the stamps do not advance with time (they stand still, or count in other units); then `host` returns
  /// arrival times.
  bool usable() const { return usable_; }
  /// True: the clock was read, and `host` returns the time at which the camera stamped a frame.
  bool read() const { return usable_ && read_.has_value(); }
  /// The delay from a stamp to its frame's first packet; none: not known, or not yet.
  std::optional<double> delay() const { return delay_; }

 private:
  struct Bucket {
    double until;
    double least;
  };
  struct Pair {
    double stamp, arrived;
  };
  static constexpr double window = 2.0, bucket = 0.25, learning = 1.0;
  static constexpr double same_rate = 0.01;      // a clock whose rate differs by more is not usable
  static constexpr double allowed_jitter = 0.1;  // of arrivals

  double least() const {
    return std::min_element(buckets_.begin(), buckets_.end(),
                            [](const Bucket& a, const Bucket& b) { return a.least < b.least; })
        ->least;
  }
  /// Starts again after the camera's clock was set back.
  void restart() {
    buckets_.clear();
    recent_.fill(none);
    read_.reset();
    delay_.reset();
  }
  void update(double arrived, double difference) {
    if (buckets_.empty() || arrived >= buckets_.back().until)
      buckets_.push_back({arrived + bucket, difference});
    else
      buckets_.back().least = std::min(buckets_.back().least, difference);
    while (buckets_.front().until < arrived - window) buckets_.pop_front();
  }
  std::optional<double> read_, delay_;
  std::deque<Bucket> buckets_;
  static constexpr double none = std::numeric_limits<double>::infinity();
  std::array<double, 4> recent_{none, none, none, none};  // the last differences
  std::size_t frames_ = 0;
  Pair first_{};
  double last_stamp_ = 0.0;
  bool usable_ = true;
};

}  // namespace skein::vision::detail
