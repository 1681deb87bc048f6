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

/// Bounds on a modified reference of one robot with which (18f, g) still hold with the present couplings.
struct ReferenceBounds {
  double v;      ///< largest v_ref [m/s]
  double omega;  ///< largest |omega_ref| + k_y v_ref [rad/s]
  double k_y;

  /// The largest turning rate: it leaves part of the common bound to the forward speed.
  double omega_limit() const noexcept { return 0.6 * omega; }
  /// The largest forward speed at this turning rate, never negative.
  double v_limit(double omega_ref) const noexcept;
};
ReferenceBounds reference_bounds(const Gains& gains, std::size_t i) noexcept;

/// The state of the floor at one moment.
struct Scene {
  std::span<const Pose> poses;    ///< NaN: not known, and no obstructor
  std::span<const Twist> twists;  ///< the last command of each
  std::span<const bool> held;     ///< whose forward speed the shield changed at the last tick
  std::span<const Obstacle> obstacles;
  double keep = 0.09;  ///< distance to keep between two midpoints of standard bodies; a little over the shield's [m]
  double half_width = std::numeric_limits<double>::infinity();  ///< of the area for their midpoints [m]
  double half_height = std::numeric_limits<double>::infinity();
  Sizes sizes = {};  ///< of the bodies
};

/// A robot's next course: heading, speed, and whether it is clear.
struct Course {
  double heading = 0.0;  ///< [rad]
  double speed = 0.0;    ///< [m/s]
  bool direct = true;
  bool clear = true;  ///< no robot or obstacle is met on it within the horizon
};

/// Looks ahead: simulates unicycle courses in all directions against the predicted positions of the others (constant
/// twists), and takes the one that brings the robot nearest to the predicted position of its goal, with a bias to the
/// right. Robots pass one another on the right, which turns a crowd that meets in one point into a roundabout.
/// Deterministic; only the constructor allocates.
class Steering {
 public:
  Steering(std::size_t robots, std::size_t obstacles);

  struct Query {
    std::size_t robot;
    std::span<const std::uint32_t> near;  ///< the robots to consider
    Pose from;                            ///< its position, and the heading of its reference
    ReferencePoint goal;                  ///< moves on at a constant twist
    ReferenceBounds bounds;
    double horizon;       ///< [s]
    double last_heading;  ///< of its last course; NaN: it had none [rad]
    double last_omega;    ///< of its reference [rad/s]
    /// How long it has blocked others [s]; the longer, the smaller the weight of its goal, and the sooner it drives to
    /// wherever there is room.
    double waited;
  };
  Course choose(const Scene& scene, const Query& query) noexcept;

  /// Whether robot i meets a robot or obstacle within the horizon if it drives on along its reference.
  bool conflict(const Scene& scene, std::size_t i, std::span<const std::uint32_t> near, const ReferencePoint& reference,
                double horizon) noexcept;

  /// The twist of a reference that turns to a heading and drives that way.
  static Twist towards(double heading, double speed, double theta, const ReferenceBounds& bounds) noexcept;

 private:
  struct Mover {
    double x, y, v_x, v_y, keep;
  };
  struct Ride {
    double held;     // share of the course with a conflict
    double off;      // mean distance from the goal on the course [m]
    double closest;  // smallest distance to another, minus the distance to keep [m]
  };
  void gather_movers(const Scene& scene, std::size_t i, std::span<const std::uint32_t> near, double x, double y,
                     double reach) noexcept;
  double gap(double x, double y, double t) const noexcept;
  Ride ride(const Scene& scene, const Query& query, double heading, double speed) const noexcept;

  std::vector<Mover> movers_;
};

}  // namespace skein::core
