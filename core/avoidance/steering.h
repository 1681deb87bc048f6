#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/avoidance/obstacle.h"
#include "core/control/gains.h"
#include "core/control/tracking_error.h"
#include "core/geometry/pose.h"

namespace skein::core {

/// What a modified reference of one robot may ask, so that (18f, g) go on holding with the present couplings.
struct ReferenceBounds {
  double v;      ///< largest v_ref [m/s]
  double omega;  ///< largest |omega_ref| + k_y v_ref [rad/s]
  double k_y;

  /// The largest turning rate: it leaves at least a part of the common bound to the forward speed.
  double omega_limit() const noexcept { return 0.6 * omega; }
  /// The largest forward speed beside this turning rate, never negative.
  double v_limit(double omega_ref) const noexcept;
};
ReferenceBounds reference_bounds(const Gains& gains, std::size_t i) noexcept;

/// What stands and drives on the floor at one moment.
struct Scene {
  std::span<const Pose> poses;    ///< NaN: not known, and nobody's obstructor
  std::span<const Twist> twists;  ///< what each was told last
  std::span<const bool> held;     ///< whose forward speed the shield changed at the last tick
  std::span<const Obstacle> obstacles;
  double keep = 0.09;  ///< distance to keep between two midpoints of standard bodies; a little over the shield's [m]
  double half_width = std::numeric_limits<double>::infinity();  ///< of where their midpoints may be [m]
  double half_height = std::numeric_limits<double>::infinity();
  Sizes sizes = {};  ///< of the bodies
};

/// The way a robot takes next: which way, how fast, and whether that is straight to its goal with nobody in the way.
struct Course {
  double heading = 0.0;  ///< [rad]
  double speed = 0.0;    ///< [m/s]
  bool direct = true;
  bool clear = true;  ///< nobody is met on it within the horizon
};

/// Looks ahead: tries courses all around, as the unicycle would really drive them, against where the others will be if
/// they drive on as they do, and takes the one that brings the robot nearest to where its goal will be, with a bias to
/// the right. Everybody passes everybody else on the right, which turns a crowd that meets in one point into a
/// roundabout. Deterministic, and it allocates nothing after it was made.
class Steering {
 public:
  Steering(std::size_t robots, std::size_t obstacles);

  /// The course of robot i from `from` (its position, and the heading of its reference). `near`: the robots to look at.
  /// `goal`: drives on as it does. `last`: the heading of its last course, or NaN; `turning`: its last
  /// turning rate. `waited`: how long it has stood in
  /// others' way [s]; the longer, the less it insists on its goal, and the sooner it goes wherever there is room.
  Course choose(const Scene& scene, std::size_t i, std::span<const std::uint32_t> near, const Pose& from,
                const ReferencePoint& goal, const ReferenceBounds& bounds, double horizon, double last, double turning,
                double waited) noexcept;

  /// Whether robot i meets somebody within the horizon if it drives on along its reference.
  bool conflict(const Scene& scene, std::size_t i, std::span<const std::uint32_t> near, const ReferencePoint& reference,
                double horizon) noexcept;

  /// The twist of a reference that turns to a heading and drives that way.
  static Twist towards(double heading, double speed, double theta, const ReferenceBounds& bounds) noexcept;

 private:
  struct Mover {
    double x, y, v_x, v_y, keep;
  };
  struct Ride {
    double held;     // share of the way on which somebody is met
    double off;      // mean distance from the goal on the way [m]
    double closest;  // to anybody, less what is to be kept [m]
  };
  void look(const Scene& scene, std::size_t i, std::span<const std::uint32_t> near, double x, double y,
            double reach) noexcept;
  double gap(double x, double y, double t) const noexcept;
  Ride ride(const Scene& scene, std::size_t i, const Pose& from, double heading, double speed,
            const ReferencePoint& goal, const ReferenceBounds& bounds, double horizon) const noexcept;

  std::vector<Mover> movers_;
};

}  // namespace skein::core
