#pragma once

#include <span>

#include "core/control/gains.h"
#include "core/control/law_pairs.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// The coordinated tracking controller (15) for a group of n robots.
/// errors, reference, command: one entry per robot, in the gains' order; command must not overlap the inputs. Commands
/// are not limited here: see core/safety/limits.h.
///
/// A robot whose error is given as zero leaves the group: every coupling to it and its share of the common normaliser
/// vanish. The formulas are those of the paper with the third term of (15b) read as k_y v_ref k y_e / sqrt(1 + k^2
/// e_xy' e_xy) sinc(theta_e).
void coordination_law(const Gains& gains, std::span<const TrackingError> errors, std::span<const Twist> reference,
                      std::span<Twist> command) noexcept;

/// The same to 1e-12 of the limits for large groups, whose pairs are vectorised; bit for bit the same for small groups.
/// The results are the same on every processor. `pairs` is constructed for at least as many robots.
void coordination_law(const Gains& gains, std::span<const TrackingError> errors, std::span<const Twist> reference,
                      std::span<Twist> command, LawPairs& pairs) noexcept;

/// The coupling sums (21, 22) over the group: A_x, A_theta and A_y are zero except for rounding. They are the coupling
/// terms' contribution to dV/dt, computed from the terms as (15) applies them.
struct CouplingSums {
  double x, theta, y;
};
CouplingSums coupling_sums(const Gains& gains, std::span<const TrackingError> errors) noexcept;

/// sqrt(1 + k^2 e_xy' e_xy), the normaliser that (15b), (19) and (20) share; e_xy stacks the position errors of ALL
/// robots (12).
double group_normaliser(double k, std::span<const TrackingError> errors) noexcept;

}  // namespace skein::core
