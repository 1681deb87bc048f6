#pragma once

#include <span>

#include "core/control/gains.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// (19): V = (k_y/k) sqrt(1 + k^2 e_xy' e_xy) + theta_e' theta_e / 2 - k_y/k. Zero where every error is zero, else
/// positive.
double lyapunov(const Gains& gains, std::span<const TrackingError> errors) noexcept;

/// (20): dV/dt when the commands are those of (15); never positive. The couplings do not appear: (21, 22) cancel them.
double lyapunov_rate(const Gains& gains, std::span<const TrackingError> errors) noexcept;

/// dV/dt for ANY commands, from the gradient of (19) and the error dynamics (5).
double lyapunov_rate(const Gains& gains, std::span<const TrackingError> errors, std::span<const Twist> reference,
                     std::span<const Twist> command) noexcept;

}  // namespace skein::core
