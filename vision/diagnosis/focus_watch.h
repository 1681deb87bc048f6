#pragma once

#include <limits>
#include <optional>
#include <string>

#include "vision/diagnosis/lasting_fault.h"

namespace skein::vision {

/// Whether the robots' tags are as sharp as they were: a lens whose ring turns, that warms up, or whose autofocus
/// hunts blurs all of them, until small ones are no longer recognised. For one thread.
class FocusWatch {
 public:
  /// A lens in focus blurs by 0.8 px. By this much more than it did once, it has lost its focus; by this much, it never
  /// had it. [px]
  static constexpr double growth = 0.35;
  static constexpr double blurred = 1.4;

  /// `blur` as TagTracker::blur has it, at time `t` [s]. What to tell people, without a full stop, as soon as it has
  /// been out of focus for two seconds, once until it is in focus again; else empty.
  std::string update(double t, std::optional<double> blur);

 private:
  double sharpest_ = std::numeric_limits<double>::infinity();
  LastingFault fault_;
};

}  // namespace skein::vision
