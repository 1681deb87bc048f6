#pragma once

#include <optional>
#include <string>

#include "vision/calibration/calibration.h"
#include "vision/diagnosis/lasting_fault.h"

namespace skein::vision {

/// Whether the robots' tags look as large as the calibration says. If all of them are larger or smaller by a few per
/// cent, tag_size, tag_height or the camera's own height is wrong; a wrong height makes every pose wrong, too. For one
/// thread.
class ScaleWatch {
 public:
  /// Good prints and calibrations differ by less. It corresponds to 18 mm of height under a camera at 1.8 m.
  static constexpr double tolerance = 0.010;

  explicit ScaleWatch(const Calibration& calibration) : calibration_(calibration) {}

  /// `stretch`: TagTracker::stretch at time `t` [s]. Returns a message for the operator, without a full stop, once it
  /// has been out of tolerance for two seconds, and not again until it has been in tolerance; otherwise empty.
  std::string update(double t, std::optional<double> stretch);

 private:
  Calibration calibration_;
  LastingFault fault_;
};

}  // namespace skein::vision
