#pragma once

#include <string_view>

#include "core/avoidance/obstacle.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// The methods that modify references for collision avoidance.
enum class AvoidanceKind {
  field,  ///< the paper's (29)-(34), with detours for stuck robots
  plan,   ///< planned routes: `Planner`
};

/// As files call it (core/words.h).
constexpr std::string_view word(AvoidanceKind kind) noexcept {
  switch (kind) {
    case AvoidanceKind::field:
      return "field";
    case AvoidanceKind::plan:
      return "plan";
  }
  return {};
}

/// Parameters of the artificial potential field (29-34).
struct AvoidanceParameters {
  AvoidanceKind kind = AvoidanceKind::field;
  bool enabled = true;
  double alpha = 0.10;   ///< half width of the detection region along x [m]; must be smaller than the formation's
                         ///< spacing
  double beta = 0.10;    ///< along y [m]
  int p = 2;             ///< shape: 2 an ellipse, larger more like a rectangle
  double K_a = 0.1;      ///< attraction to the reference [1/s]
  double K_o = 0.02;     ///< repulsion [m^2/s]
  double horizon = 0.0;  ///< look-ahead instead of the field [s]; 0: the field, and detours only for stuck robots
  bool formation_waits = false;  ///< plan: the formation slows down while one of its robots returns to it
  bool improve = true;           ///< plan: better routes are searched for while robots drive
};

/// |dx/alpha|^p + |dy/beta|^p of (30), with absolute values (an odd p would make it negative): at most 1 inside the
/// region.
double region_level(const AvoidanceParameters& parameters, double dx, double dy) noexcept;

/// V_i,j of (30) at robot pose (x, y); zero outside the detection region.
double potential(const AvoidanceParameters& parameters, double x, double y, double x_ref, double y_ref, double x_j,
                 double y_j) noexcept;

/// A velocity in the world frame. [m/s]
struct Velocity {
  double x = 0.0;
  double y = 0.0;
};

/// Minus the gradient of (30) with respect to (x, y): the contribution of obstructor j to (31). Zero outside the
/// region.
Velocity descent(const AvoidanceParameters& parameters, double x, double y, double x_ref, double y_ref, double x_j,
                 double y_j) noexcept;

/// The region for a pair whose bodies together exceed two standard ones by this much [m].
AvoidanceParameters wider(const AvoidanceParameters& parameters, double by) noexcept;

/// The region around a round obstacle: the same gap between the bodies as between two robots.
AvoidanceParameters around(const AvoidanceParameters& parameters, const Obstacle& obstacle) noexcept;

}  // namespace skein::core
