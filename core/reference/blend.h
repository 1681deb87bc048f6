#pragma once

namespace skein::core {

/// Progress of a change: the completed share, its rate [1/s] and its second derivative [1/s^2]. Zero velocity and
/// acceleration at both ends (10 w^3 - 15 w^4 + 6 w^5).
struct Blend {
  double share, rate, rate_rate;
  static constexpr double steepest = 1.875;  ///< the largest rate, times the duration
};

/// `since` the beginning, between 0 and `duration`. [s]
inline Blend blend(double since, double duration) noexcept {
  const double w = since / duration, rest = 1.0 - w;
  return {w * w * w * (10.0 + w * (6.0 * w - 15.0)), 30.0 * w * w * rest * rest / duration,
          60.0 * w * rest * (1.0 - 2.0 * w) / (duration * duration)};
}

}  // namespace skein::core
