#pragma once

#include <cmath>
#include <string_view>

#include "core/math/elementary.h"

namespace skein::core {

/// The two saturation functions of (11), members of the set S_{r,k} of (10): odd, smooth, bounded by r.
enum class Saturation {
  tanh,       ///< (11b)  phi_r(kx) = r tanh(kx), the one that (36) uses
  algebraic,  ///< (11a)  phi_r(kx) = r kx / sqrt(1 + (kx)^2)
};

/// As files call it (core/words.h).
constexpr std::string_view word(Saturation kind) noexcept {
  switch (kind) {
    case Saturation::tanh:
      return "tanh";
    case Saturation::algebraic:
      return "algebraic";
  }
  return {};
}

/// phi_r(kx) of (11): bounded by `r`, slope r at kx = 0.
inline double saturate(Saturation kind, double r, double kx) noexcept {
  switch (kind) {
    case Saturation::tanh:
      return r * math::tanh(kx);
    case Saturation::algebraic:
      break;
  }
  return r * kx / std::sqrt(1.0 + kx * kx);
}

}  // namespace skein::core
