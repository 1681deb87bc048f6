#include "core/controllers/independent.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {

Twist track_alone(const Gains& gains, std::size_t i, const TrackingError& e, const Twist& reference) noexcept {
  const bool fixed = gains.policy == GainPolicy::fixed;
  const double k_x = fixed ? gains.k_x[i] : std::max(0.0, gains.v_max[i] - std::abs(reference.v));
  const double k_theta =
      fixed ? gains.k_theta[i]
            : std::max(0.0, gains.omega_max[i] - std::abs(reference.omega) - gains.k_y * std::abs(reference.v));
  const double normaliser = std::sqrt(1.0 + gains.k * gains.k * (e.x * e.x + e.y * e.y));
  return {reference.v * math::cos(e.theta) + saturate(gains.saturation, k_x, gains.c_x[i] * e.x),
          reference.omega + saturate(gains.saturation, k_theta, gains.c_theta[i] * e.theta) +
              gains.k_y * reference.v * gains.k * e.y / normaliser * sinc(e.theta)};
}

}  // namespace skein::core
