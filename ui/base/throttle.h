#pragma once

#include <limits>

namespace skein::ui {

/// Lets something be done at most so often, however often or rarely it is asked. Time is an argument.
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
