#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace skein::core {

/// Standard deviations from the middle of a normal distribution to either end of its 95 % interval.
inline constexpr double z_95 = 1.959963984540054;

/// The median; for an even number of values the upper one of the two in the middle. Reorders the values; there must be
/// at least one. Does not allocate.
inline double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
/// The same of a copy.
inline double median(std::vector<double> values) {
  return median_of(values);
}

}  // namespace skein::core
