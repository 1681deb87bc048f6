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
  /// A lens in focus blurs by 0.8 px. It has lost its focus if it blurs by `growth` more than it did at its sharpest,
  /// and was never in focus if it blurs by `blurred`. [px]
  static constexpr double growth = 0.35;
  static constexpr double blurred = 1.4;

  /// `blur`: TagTracker::blur at time `t` [s]. Returns a message for the operator, without a full stop, once the lens
  /// has been out of focus for 0.6 s, and not again until it has been in focus; otherwise empty.
  std::string update(double t, std::optional<double> blur);
  /// How much the lens blurs while it is out of focus [px]; none: it is in focus.
  const std::optional<double>& out_of_focus() const { return out_of_focus_; }

 private:
  double sharpest_ = std::numeric_limits<double>::infinity();
  LastingFault fault_{0.6};  // [s]
  std::optional<double> out_of_focus_;
};

}  // namespace skein::vision
