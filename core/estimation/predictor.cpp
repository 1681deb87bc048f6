#include "core/estimation/predictor.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"

namespace skein::core {

void Predictor::command(double acts_at, const Twist& twist) noexcept {
  entries_[count_++ % memory] = {acts_at, twist};
}

std::optional<Predictor::Leg> Predictor::forgets_next() const noexcept {
  if (count_ < memory) return {};
  const Entry& oldest = entries_[count_ % memory];
  return Leg{oldest.twist, oldest.from, entries_[(count_ + 1) % memory].from};
}

bool Predictor::remembers(double time) const noexcept {
  return count_ <= memory || entries_[count_ % memory].from <= time;
}

template <typename Use>
void Predictor::between(double from, double to, Use&& use) const noexcept {
  const std::size_t oldest = count_ > memory ? count_ - memory : 0;
  std::size_t first = count_;  // in force at `from`, which is recent
  while (first > oldest && !(first < count_ && entries_[first % memory].from <= from)) --first;
  for (std::size_t k = first; k < count_; ++k) {
    const Entry& entry = entries_[k % memory];
    const double next = k + 1 < count_ ? entries_[(k + 1) % memory].from : to;
    const double begin = std::max(entry.from, from), end = std::min(next, to);
    if (end > begin && !(entry.twist == Twist{})) use(entry.twist, end - begin);
  }
}

Pose Predictor::predict(const Pose& from, double captured_at, double time) const noexcept {
  Pose pose = from;
  between(captured_at, time, [&](const Twist& twist, double seconds) { pose = advance(pose, twist, seconds); });
  return pose;
}

Predictor::Way Predictor::way(double from, double to) const noexcept {
  Way way;
  between(from, to, [&](const Twist& twist, double seconds) {
    way.driven += std::abs(twist.v) * seconds;
    way.turned += std::abs(twist.omega) * seconds;
  });
  return way;
}

}  // namespace skein::core
