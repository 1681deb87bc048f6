#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/avoidance/potential_field.h"
#include "core/control/gains.h"
#include "core/control/tracking_error.h"

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

/// Collision avoidance by changed references, (29)-(34), one state machine a robot:
///   nominal    the reference is the formation's
///   avoiding   another robot or an obstacle is inside the detection region: (31)-(34) make the reference
///   returning  nobody is: the reference drives back to the formation's as a unicycle of its own
/// Beyond the paper: v_ref and omega_ref stay inside `reference_bounds` (34e reaches 78 rad/s, and the gains of (36)
/// then turn negative); the heading of the reference turns at a bounded rate and v_ref is the part of the repulsion
/// along it, so that the reference is one that a unicycle can follow; a region once entered is left only at 1.1 times
/// its size; and on leaving the reference does not jump back to the nominal one.
class Avoidance {
 public:
  enum class State { nominal, avoiding, returning };

  explicit Avoidance(std::size_t robots) : robots_(robots) {}

  /// One step of length dt [s]. A robot whose pose is not known (NaN) is nobody's obstructor. reference[i] is written
  /// for every robot: equal to nominal[i], bit for bit, in state nominal.
  void step(const AvoidanceParameters& parameters, const Gains& gains, double dt, std::span<const Pose> poses,
            std::span<const Obstacle> obstacles, std::span<const ReferencePoint> nominal,
            std::span<ReferencePoint> reference) noexcept;

  State state(std::size_t i) const noexcept { return robots_[i].state; }
  /// Forget robot i's modified reference, for example when it has been put somewhere else.
  void reset(std::size_t i) noexcept { robots_[i] = {}; }

 private:
  struct Robot {
    State state = State::nominal;
    ReferencePoint reference;  // while not nominal
    Pose previous;             // its pose at t_{k-1}
    bool has_previous = false;
  };

  std::vector<Robot> robots_;
};

}  // namespace skein::core
