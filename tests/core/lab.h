#pragma once

#include "core/planning/lattice.h"

namespace skein::test {

constexpr double dt = 0.04;                 ///< the controller's period, 25 Hz [s]
constexpr core::HalfSize arena{1.0, 0.75};  ///< of the paper's lab [m]

}  // namespace skein::test
