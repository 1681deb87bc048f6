#include "core/control/lyapunov.h"

#include <cmath>

#include "core/control/coordination_law.h"

namespace skein::core {

double lyapunov(const Gains& gains, std::span<const TrackingError> errors) noexcept {
  double squares = 0.0;
  double headings = 0.0;
  for (const TrackingError& e : errors) {
    squares += e.x * e.x + e.y * e.y;
    headings += e.theta * e.theta;
  }
  // (k_y/k)(sqrt(1 + a) - 1) written as (k_y/k) a / (sqrt(1 + a) + 1): no cancellation near 0.
  const double a = gains.k * gains.k * squares;
  return gains.k_y / gains.k * a / (std::sqrt(1.0 + a) + 1.0) + 0.5 * headings;
}

double lyapunov_rate(const Gains& gains, std::span<const TrackingError> errors) noexcept {
  const double normaliser = group_normaliser(gains.k, errors);
  double rate = 0.0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TrackingError& e = errors[i];
    rate -= gains.k_y * gains.k * e.x * saturate(gains.saturation, gains.k_x[i], gains.c_x[i] * e.x) / normaliser;
    rate -= e.theta * saturate(gains.saturation, gains.k_theta[i], gains.c_theta[i] * e.theta);
  }
  return rate;
}

double lyapunov_rate(const Gains& gains, std::span<const TrackingError> errors, std::span<const Twist> reference,
                     std::span<const Twist> command) noexcept {
  const double normaliser = group_normaliser(gains.k, errors);
  double rate = 0.0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TrackingError& e = errors[i];
    const TrackingError de = error_rate(e, reference[i], command[i]);
    rate += gains.k_y * gains.k * (e.x * de.x + e.y * de.y) / normaliser + e.theta * de.theta;
  }
  return rate;
}

}  // namespace skein::core
