#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace skein::comms {

/// The round-trip times of the last 256 exchanges (10 s at 25 Hz).
class RoundTrips {
 public:
  void add(double seconds) noexcept { times_[count_++ % times_.size()] = seconds; }

  /// The value that a share of the times lies at or below: 0.5 the median; 0 before the first. [s]
  double quantile(double share) const {
    const std::size_t size = std::min(count_, times_.size());
    if (size == 0) return 0.0;
    auto sorted = times_;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(size);
    const auto nth = sorted.begin() + std::lround(share * static_cast<double>(size - 1));
    std::nth_element(sorted.begin(), nth, end);
    return *nth;
  }

 private:
  std::array<double, 256> times_{};
  std::size_t count_ = 0;
};

}  // namespace skein::comms
