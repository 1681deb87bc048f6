#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "core/geometry/pose.h"
#include "core/safety/limits.h"

namespace skein::app {

/// Half the arena's size, centred on the origin. [m]
struct HalfArena {
  double width = 1.0, height = 0.75;
};

/// A method by which robots that know all positions drive to places without touching, for comparison with Skein's
/// planner.
class SwapMethod {
 public:
  virtual ~SwapMethod() = default;
  /// One step of dt [s]: what each robot does next. `commands` are those of the previous step, and are replaced.
  virtual void step(std::span<const core::Pose> poses, std::span<const core::Pose> places, double dt,
                    std::span<core::Twist> commands) = 0;
};

/// Optimal reciprocal collision avoidance for differential drives (Alonso-Mora, Breitenmoser, Rufli, Beardsley,
/// Siegwart, 2010): each robot makes half of the change that keeps its velocity out of the others' velocity obstacles
/// (van den Berg et al., 2011), among the holonomic velocities that its wheels follow with an error of at most epsilon,
/// by which its radius is enlarged. epsilon shrinks near other robots, as in the paper.
std::unique_ptr<SwapMethod> make_nh_orca(const core::CommandLimits& limits, HalfArena arena);

/// Safety barrier certificates (Wang, Ames, Egerstedt, 2017) as the Robotarium uses them for unicycles: for a point
/// ahead of each robot, the velocities nearest to those that lead to the places, under one barrier for each pair; found
/// by coordinate ascent on the dual. Robots in a deadlock turn to the right for a while.
std::unique_ptr<SwapMethod> make_barrier_certificates(const core::CommandLimits& limits, HalfArena arena);

/// The distance, at the end of the turn, between a differential drive that turns by `angle` [rad] as NH-ORCA drives it
/// and a point that sets off at `speed` [m/s] in the new direction at once. [m]
double nh_orca_error(const core::CommandLimits& limits, double angle, double speed);

}  // namespace skein::app
