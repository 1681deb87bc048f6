#pragma once

#include <cmath>

#include "core/estimation/latency_fit.h"
#include "core/geometry/pose.h"

namespace skein::test {

/// A turn to and fro as a robot's counters and a camera would tell it whose stamps are late by 20 ms, from its middle
/// on by `wander` more. [s]
inline core::TurnRecord turn_with_wandering_stamps(double wander) {
  core::TurnRecord turn;
  const double steps = 0.5 * turn.believed.track / turn.believed.metres_per_step();  // of each wheel for a rad
  const auto heading = [](double phase) { return 0.6 * (1.0 - std::cos(2.0 * core::pi * phase)); };
  for (int k = 0; k < 300; ++k) {
    const double t = 0.04 * k, at = heading(0.6 * t * (1.0 + 0.05 * t));
    turn.wheels.push_back({t, std::round(-steps * at), std::round(steps * at)});
    const double late = 0.02 + (t < 6.0 ? 0.0 : wander);
    turn.poses.push_back({t + late, {0.0, 0.0, core::wrap_angle(at + 1e-3 * std::sin(17.0 * k))}});
  }
  return turn;
}

}  // namespace skein::test
