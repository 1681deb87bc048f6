#pragma once

#include <cmath>

namespace skein::core {

/// The two saturation functions of (11), members of the set S_{r,k} of (10): odd, smooth, bounded by r.
enum class Saturation {
  tanh,       ///< (11b)  phi_r(kx) = r tanh(kx), the one that (36) uses
  algebraic,  ///< (11a)  phi_r(kx) = r kx / sqrt(1 + (kx)^2)
};

/// phi_r(kx) of (11): bounded by `r`, slope r at kx = 0.
inline double saturate(Saturation kind, double r, double kx) noexcept {
  return kind == Saturation::tanh ? r * std::tanh(kx) : r * kx / std::sqrt(1.0 + kx * kx);
}

}  // namespace skein::core
