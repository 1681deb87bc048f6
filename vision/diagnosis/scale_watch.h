#pragma once

#include <optional>
#include <string>

#include "vision/calibration/calibration.h"
#include "vision/diagnosis/lasting_fault.h"
#include "vision/tags/scale_change.h"

namespace skein::vision {

/// Whether the robots' tags look as large as the calibration says. If all of them are larger or smaller by a few per
/// cent, tag_size, tag_height or the camera's own height is wrong; a wrong height makes every pose wrong, too. And
/// whether all of them become larger or smaller at once: the camera was raised or lowered, or its zoom has changed. For
/// one thread.
class ScaleWatch {
 public:
  /// Good prints and calibrations differ by less. It corresponds to 18 mm of height under a camera at 1.8 m.
  static constexpr double tolerance = 0.010;

  /// A change of all tags' size at once is reported from this on, ...
  static constexpr double steady = 0.005;
  /// ... and from this on, where three tags or more show it, the camera counts as moved: the tracker does not report
  /// tags that change as much (TrackerOptions::lift_tolerance). Two robots may be lifted with two hands: of two tags
  /// the change must stay the same for a second, ...
  static constexpr double moved_from = 0.012;
  /// ... to this: 7 mm of height under a camera at 2.4 m, which hands do not keep.
  static constexpr double same_change = 0.003;

  explicit ScaleWatch(const Calibration& calibration) : calibration_(calibration) {}

  /// `stretch`: TagTracker::stretch at time `t` [s]. Returns a message for the operator, without a full stop, once it
  /// has been out of tolerance for two seconds, and not again until it has been in tolerance; otherwise empty.
  std::string update(double t, std::optional<double> stretch);

  /// The same of TagTracker::scale_change, once it has lasted for 0.4 s.
  std::string update_change(double t, const std::optional<ScaleChange>& change);
  /// The change that shows that the camera has moved, as it was first seen, for as long as there is one.
  const std::optional<ScaleChange>& moved() const { return moved_; }

 private:
  bool keeps(const ScaleChange& change);

  Calibration calibration_;
  LastingFault fault_;
  LastingFault change_{0.4}, move_{0.1}, still_{1.0};  // [s]
  std::optional<double> pair_;                         // the change that two tags showed first
  std::optional<ScaleChange> moved_;
};

}  // namespace skein::vision
