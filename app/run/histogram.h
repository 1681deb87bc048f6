#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/math/elementary.h"

namespace skein::app {

/// A histogram of durations: 16 bins per octave (4.4 %) from 1 us to 16 s, with a fixed size. Shorter and longer
/// durations count in the end bins; none is ignored.
class Histogram {
 public:
  static constexpr double shortest = 1e-6;  ///< [s]
  static constexpr int per_octave = 16;
  static constexpr std::size_t sizes = 24 * per_octave;

  void add(double seconds) noexcept {
    if (std::isnan(seconds)) return;
    const double size = seconds > shortest ? std::floor(core::math::log2(seconds / shortest) * per_octave) : 0.0;
    ++counts_[std::min(static_cast<std::size_t>(size), sizes - 1)];
    ++total_;
    largest_ = std::max(largest_, seconds);
  }

  Histogram& operator+=(const Histogram& other) noexcept {
    for (std::size_t size = 0; size < sizes; ++size) counts_[size] += other.counts_[size];
    total_ += other.total_;
    largest_ = std::max(largest_, other.largest_);
    return *this;
  }
  /// What was added since this earlier copy of the histogram was taken. The largest is exact if it was added since,
  /// otherwise rounded up to the end of its bin.
  Histogram since(const Histogram& earlier) const noexcept {
    Histogram added;
    for (std::size_t size = 0; size < sizes; ++size) {
      added.counts_[size] = counts_[size] - earlier.counts_[size];
      if (added.counts_[size] > 0) added.largest_ = std::min(upper_end(size), largest_);
    }
    if (largest_ > earlier.largest_) added.largest_ = largest_;
    added.total_ = total_ - earlier.total_;
    return added;
  }

  std::uint64_t total() const noexcept { return total_; }
  std::uint64_t count(std::size_t size) const noexcept { return counts_[size]; }
  double largest() const noexcept { return largest_; }  ///< exact; 0: there was none [s]

  /// The quantile of the durations for this share, rounded up to the end of its bin (at most 4.4 %). 0: there was none.
  /// [s]
  double quantile(double share) const noexcept {
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(total_)));
    std::uint64_t so_far = 0;
    for (std::size_t size = 0; size < sizes; ++size)
      if ((so_far += counts_[size]) >= std::max<std::uint64_t>(1, wanted)) return std::min(upper_end(size), largest_);
    return largest_;
  }

 private:
  // [s]
  static double upper_end(std::size_t size) noexcept {
    return shortest * core::math::exp2(static_cast<double>(size + 1) / per_octave);
  }

  std::array<std::uint64_t, sizes> counts_{};
  std::uint64_t total_ = 0;
  double largest_ = 0.0;
};

}  // namespace skein::app
