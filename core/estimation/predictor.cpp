#include "core/estimation/predictor.h"

#include <algorithm>

#include "core/kinematics/unicycle.h"

namespace skein::core {

void Predictor::command(double acts_at, const Twist& twist) noexcept {
  entries_[count_++ % memory] = {acts_at, twist};
}

Pose Predictor::predict(const Measurement& measurement, double time) const noexcept {
  Pose pose = measurement.pose;
  const std::size_t oldest = count_ > memory ? count_ - memory : 0;
  for (std::size_t k = oldest; k < count_; ++k) {
    const Entry& entry = entries_[k % memory];
    const double until = k + 1 < count_ ? entries_[(k + 1) % memory].from : time;
    const double from = std::max(entry.from, measurement.captured_at);
    const double to = std::min(until, time);
    if (to > from) pose = advance(pose, entry.twist, to - from);
  }
  return pose;
}

}  // namespace skein::core
