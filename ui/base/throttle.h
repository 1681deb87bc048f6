#pragma once

#include <limits>

namespace skein::ui {

/// Limits how often something is done, however often it is requested. Time is an argument.
class Throttle {
 public:
  explicit Throttle(double seconds) : seconds_(seconds) {}

  bool due(double now) {
    if (now - last_ < seconds_) return false;
    last_ = now;
    return true;
  }

 private:
  double seconds_, last_ = -std::numeric_limits<double>::infinity();
};

}  // namespace skein::ui
