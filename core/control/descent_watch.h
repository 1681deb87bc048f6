#pragma once

#include <span>
#include <vector>

#include "core/control/gains.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// Checks whether V of (19) falls as (20) predicts. In continuous time V never rises; between two samples it may
/// rise a little: commands are held, references jump in omega where a bend begins, limits and shield reduce
/// commands. All of that is known, so that V can be predicted: it is the V of robots that drive from their last
/// poses exactly as commanded, with the present references. A rise beyond both the last value and this prediction is
/// unexplained, and is summed; each tick in which V stays below reduces the sum. Part of the tick: allocates in its
/// constructor only.
class DescentWatch {
 public:
  /// `tolerance`: the sum that noise alone may reach [the unit of V, rad^2].
  DescentWatch(std::size_t robots, double tolerance)
      : tolerance_(tolerance), poses_(robots), twists_(robots), expected_(robots) {}

  /// One tick, `dt` after the last one [s]: the robots' poses, references and errors (zero for a robot that
  /// does not count). Returns the unexplained rise of V when it exceeds the tolerance, and starts again;
  /// otherwise 0.
  double step(const Gains& gains, std::span<const Pose> poses, std::span<const ReferencePoint> references,
              std::span<const TrackingError> errors, double dt) noexcept;
  /// The pose from which robot i drives until the next tick, and its twist.
  void drives(std::size_t i, const Pose& from, const Twist& twist) noexcept {
    poses_[i] = from;
    twists_[i] = twist;
  }
  /// Ignores the change of V until the next tick. To be called when a robot is moved by hand, stops, is lost or is
  /// found.
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
