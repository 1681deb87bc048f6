#pragma once

#include <cstddef>

#include "core/control/gains.h"

namespace skein::core {

// The law (15) about its reference, linearised. To first order in the errors the couplings vanish (each is a product of
// two robots' errors), so that each robot is a separate loop:
//   x' = omega_ref y - k_x c_x x        y' = -omega_ref x + v_ref theta
//   theta' = -k_theta c_theta theta - k_y k v_ref y
// Its commands are held over a sampling period and act `delay` seconds after the poses from which they were computed.
// Not for the tick: these allocate.

/// The largest modulus of the eigenvalues of robot i's sampled loop with this reference: below 1, errors decrease.
/// period > 0 [s], delay >= 0 [s].
double loop_radius(const Gains& gains, std::size_t i, const Twist& reference, double period, double delay);

struct DelayMargin {
  double delay =
      0.0;  ///< the loop is stable at this delay and at every smaller one [s]; 0 also if it is stable at none
  bool unbounded = false;  ///< stable at every delay up to `delay`; longer delays were not tried
};

/// The delay margin of robot i's loop with this reference. Tries up to 64 sampling periods.
DelayMargin delay_margin(const Gains& gains, std::size_t i, const Twist& reference, double period);

/// How far robot i swings about its place at a delay beyond its loop's margin: the largest distance in the last quarter
/// of two minutes that begin 1 cm beside the place, under the law (15) without couplings. (With couplings the robot
/// swings less, since the robots share the normaliser.) (18) bounds the commands, and so the swing. Nearly 0 where the
/// loop is stable. period > 0 [s], delay >= 0 [s]. [m]
double swing(const Gains& gains, std::size_t i, const Twist& reference, double period, double delay);

}  // namespace skein::core
