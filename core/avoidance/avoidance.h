#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "core/avoidance/near_robots.h"
#include "core/avoidance/potential_field.h"
#include "core/avoidance/steering.h"
#include "core/control/gains.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// Collision avoidance by modified references, one state machine per robot:
///   nominal    the reference is the formation's
///   avoiding   another robot or an obstacle is inside the detection region: (31)-(34) make the reference
///   detouring the reference is steered round the robots in the way, see `Steering`
///   returning no obstructor is left: the reference drives back to the formation's as a unicycle
/// A robot takes a detour when it is stuck: field or shield have acted for `patience` while it made no progress towards
/// its place. With a look-ahead (horizon > 0) it does so as soon as it would meet another robot or an obstacle within
/// that time, and the field is not used.
///
/// Beyond the paper: v_ref and omega_ref stay inside `reference_bounds` (34e reaches 78 rad/s, and the gains of (36)
/// then turn negative); the heading of the reference turns at a bounded rate and v_ref is the part of the repulsion
/// along it, so that a unicycle can follow the reference; a robot leaves a region that it entered only at 1.1 times its
/// size; on leaving, the reference does not jump back to the nominal one; and a robot that was pushed away from a place
/// at rest, where the law does not reduce the lateral error, is driven back to it.
class Avoidance {
 public:
  enum class State { nominal, avoiding, detouring, returning };

  Avoidance(std::size_t robots, std::size_t obstacles);

  /// One step of length dt [s]. reference[i] is written for every robot: equal to nominal[i], bit for bit, in state
  /// nominal.
  /// `own`: the parameters of each robot, if they differ in region, attraction and repulsion (30); empty: `parameters`.
  void step(const AvoidanceParameters& parameters, const Gains& gains, double dt, const Scene& scene,
            std::span<const ReferencePoint> nominal, std::span<ReferencePoint> reference,
            std::span<const AvoidanceParameters> own = {}) noexcept;

  State state(std::size_t i) const noexcept { return robots_[i].state; }
  /// Whether this step found robot i stuck.
  bool stuck(std::size_t i) const noexcept { return robots_[i].found_stuck; }
  /// Forgets robot i's modified reference, for example after the robot was moved by hand.
  void reset(std::size_t i) noexcept { robots_[i] = {}; }

  static constexpr double patience = 3.0;  ///< [s]

 private:
  struct Robot {
    State state = State::nominal;
    ReferencePoint reference;  // while not nominal
    Pose previous;             // its pose at t_{k-1}
    bool has_previous = false;
    bool straight = false;  // returning: heads straight for its place whatever the place's heading, until it is near
    bool found_stuck = false;
    double heading = std::numeric_limits<double>::quiet_NaN();  // heading of its course while detouring
    double waited = 0.0;                                        // detouring: how long it has blocked others [s]
    double left = 0.0;                                          // detouring: previous distance to its place [m]
    double nearest = 0.0;    // distance to its place when it last made progress or was last unhindered [m]
    double stuck_for = 0.0;  // [s]
  };

  bool is_stuck(Robot& robot, double dt, bool held, double distance) const noexcept;
  void detour(std::size_t i, const AvoidanceParameters&, const Gains&, double dt, const Scene&,
              const ReferencePoint& nominal) noexcept;
  void come_back(std::size_t i, const Gains&, double dt, const ReferencePoint& nominal) noexcept;

  /// The reference that robot i is to follow.
  const ReferencePoint& follows(std::size_t i, std::span<const ReferencePoint> nominal) const noexcept {
    const bool unhindered = robots_[i].state == State::nominal;
    return unhindered ? nominal[i] : robots_[i].reference;
  }

  std::vector<Robot> robots_;
  std::vector<Twist> moves_;     // expected motion of each
  NearRobots touching_, ahead_;  // robots inside a region; robots that a detour may meet
  Steering steering_;
};

}  // namespace skein::core
