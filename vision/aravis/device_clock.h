#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

namespace skein::vision::detail {

/// A camera's own clock, told in the host's. A stamp comes with the time at which its frame's first packet arrived; no
/// packet arrives before it was sent, so that the least difference of the last two seconds has the least of the
/// network in it. Where the camera's clock could be read, what that difference is larger than the clocks' own offset
/// is the time from stamp to packet, and is taken off. Crystals that differ by 50 ppm cost 0.1 ms. All times in s.
class DeviceClock {
 public:
  /// `offset`: host's clock less the camera's, as it was read; none: it cannot be read.
  explicit DeviceClock(std::optional<double> offset = {}) : read_(offset) {}

  /// Takes a frame's stamp, and says when that was by the host's clock: where the clock was read, when the camera
  /// stamped it, else when its first packet would have arrived over an idle network. Never later than `arrived`.
  double host(double stamp, double arrived) {
    const double difference = arrived - stamp;
    if (!buckets_.empty() && stamp < last_stamp_) restart();
    if (buckets_.empty()) first_ = Pair{stamp, arrived};
    last_stamp_ = stamp;
    update(arrived, difference);
    const double passed = arrived - first_.arrived;
    usable_ = std::abs(stamp - first_.stamp - passed) <= same_rate * passed + allowed_jitter;
    if (!usable_) return arrived;
    if (!read_) return std::min(arrived, stamp + least());
    // The first second: the delay is still being learnt, and clocks have not drifted yet.
    if (!delay_ && passed >= learning) delay_ = std::max(0.0, least() - *read_);
    return std::min(arrived, stamp + (delay_ ? least() - *delay_ : *read_));
  }

  /// False: its stamps do not go with time (they stand still, or count in other units); then `host` gives arrivals.
  bool usable() const { return usable_; }
  /// True: the clock was read, and `host` says when the camera stamped a frame.
  bool read() const { return usable_ && read_.has_value(); }
  /// From a stamp to its frame's first packet; none: not known, or not yet.
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
  static constexpr double same_rate = 0.01;      // clocks that differ by more are none
  static constexpr double allowed_jitter = 0.1;  // of arrivals

  double least() const {
    return std::min_element(buckets_.begin(), buckets_.end(),
                            [](const Bucket& a, const Bucket& b) { return a.least < b.least; })
        ->least;
  }
  /// Somebody has set the camera's clock back.
  void restart() {
    buckets_.clear();
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
  Pair first_{};
  double last_stamp_ = 0.0;
  bool usable_ = true;
};

}  // namespace skein::vision::detail
