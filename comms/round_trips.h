#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace skein::comms {

/// Round-trip times of a link's exchanges: the exact last 256 (10 s at 25 Hz), and a histogram of all.
class RoundTrips {
 public:
  void add(double seconds) noexcept {
    times_[count_++ % times_.size()] = seconds;
    ++all_;
    ++classes_[class_of(seconds)];
  }

  /// Adds those of another link to the histogram, none to the last 256.
  void add(const RoundTrips& other) noexcept {
    for (std::size_t k = 0; k < classes_.size(); ++k) classes_[k] += other.classes_[k];
    all_ += other.all_;
  }

  /// The quantile of the last 256 for a share, 0.5 for the median; 0 before the first. [s]
  double quantile(double share) const {
    const std::size_t size = std::min(count_, times_.size());
    if (size == 0) return 0.0;
    auto sorted = times_;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(size);
    const auto nth = sorted.begin() + std::lround(share * static_cast<double>(size - 1));
    std::nth_element(sorted.begin(), nth, end);
    return *nth;
  }

  /// The same of all times ever added, rounded up to the end of its bin. [s]
  double quantile_since_start(double share) const noexcept {
    if (all_ == 0) return 0.0;
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(all_)));
    std::uint64_t below = 0;
    for (std::size_t k = 0; k < classes_.size(); ++k)
      if ((below += classes_[k]) >= wanted) return end_of(k);
    return end_of(classes_.size() - 1);
  }

  // Bins: each ends 5 % above the previous one, from 0.1 ms to more than 20 s.
  static constexpr std::size_t class_count = 252;
  static double end_of(std::size_t k) noexcept { return 1e-4 * std::pow(1.05, static_cast<double>(k)); }
  const std::array<std::uint64_t, class_count>& classes() const noexcept { return classes_; }

 private:
  static std::size_t class_of(double seconds) noexcept {
    const double k = std::ceil(std::log(std::max(seconds, 1e-4) / 1e-4) / std::log(1.05) - 1e-9);
    return static_cast<std::size_t>(std::clamp(k, 0.0, static_cast<double>(class_count - 1)));
  }

  std::array<double, 256> times_{};
  std::array<std::uint64_t, class_count> classes_{};
  std::size_t count_ = 0;
  std::uint64_t all_ = 0;
};

}  // namespace skein::comms
