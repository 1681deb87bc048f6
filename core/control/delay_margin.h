#pragma once

#include <cstddef>

#include "core/control/gains.h"

namespace skein::core {

// The law (15) about its reference, linearised. To first order in the errors the couplings vanish (each is a product of
// two robots' errors), so that every robot is a loop of its own:
//   x' = omega_ref y - k_x c_x x        y' = -omega_ref x + v_ref theta        theta' = -k_theta c_theta theta - k_y k
//   v_ref y
// Its commands are held over a sampling period and act `delay` seconds after the poses that they were made of.
// Not for the tick: these allocate.

/// The largest modulus of the eigenvalues of robot i's sampled loop beside this reference: below 1, errors shrink.
/// period > 0 [s], delay >= 0 [s].
double loop_radius(const Gains& gains, std::size_t i, const Twist& reference, double period, double delay);

struct DelayMargin {
  double delay =
      0.0;  ///< the largest delay for which every smaller one leaves the loop stable [s]; 0 also where none does
  bool unbounded = false;  ///< no delay up to `delay` is too much; longer ones were not tried
};

/// How much delay robot i's loop bears beside this reference. Tries up to 64 sampling periods.
DelayMargin delay_margin(const Gains& gains, std::size_t i, const Twist& reference, double period);

}  // namespace skein::core
