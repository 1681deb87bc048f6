#pragma once

#include <span>
#include <vector>

#include "core/control/gains.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// Watches whether V of (19) falls as (20) says it does. Continuous time forbids every rise; between two samples V may
/// rise a little all the same: commands are held, references jump in omega where a bend begins, limits and the shield
/// take something away. All of that is known, so that V can be worked out ahead: it is V of robots that drive from
/// their last poses exactly as they were told, seen from the references as they are now. What V rises beyond both its
/// last value and that one has no explanation, and is added up; each tick in which V stays below takes from the sum.
/// Part of the tick: allocates in its constructor only.
class DescentWatch {
 public:
  /// `tolerance`: the sum that noise may reach [the unit of V, rad^2].
  DescentWatch(std::size_t robots, double tolerance)
      : tolerance_(tolerance), poses_(robots), twists_(robots), expected_(robots) {}

  /// One tick, `dt` after the last one [s]: where the robots are, what they follow, their errors (zero for a robot that
  /// does not count). Returns by how much V has risen without an explanation as soon as that is more than the
  /// tolerance, and begins again; otherwise 0.
  double step(const Gains& gains, std::span<const Pose> poses, std::span<const ReferencePoint> references,
              std::span<const TrackingError> errors, double dt) noexcept;
  /// How robot i drives until the next tick.
  void drives(std::size_t i, const Pose& from, const Twist& twist) noexcept {
    poses_[i] = from;
    twists_[i] = twist;
  }
  /// A hand, a stop, a robot lost or found: what V does until the next tick says nothing.
  void forget() noexcept { knows_ = false, sum_ = 0.0; }

 private:
  double tolerance_;
  std::vector<Pose> poses_;
  std::vector<Twist> twists_;
  std::vector<TrackingError> expected_;
  bool knows_ = false;
  double last_ = 0.0, sum_ = 0.0;
};

}  // namespace skein::core
