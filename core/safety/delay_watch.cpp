#include "core/safety/delay_watch.h"

#include <algorithm>

#include "core/geometry/pose.h"

namespace skein::core {

void DelayWatch::see(const PoseFilter& filter, const Measurement& from, const Measurement& to,
                     double to_wheel) noexcept {
  constexpr double kept = 1.0 - 1.0 / 250.0;  // from one sight to the next
  if (!filter.remembers(from.captured_at - seconds(delays - 1))) return;
  const auto square = [&](double way, double turn) { return way * way + to_wheel * to_wheel * turn * turn; };
  const auto between = [&](const Pose& a, const Pose& b) {
    return square(distance(a, b), wrap_angle(a.theta - b.theta));
  };
  moved_ = kept * moved_ + between(from.pose, to.pose);
  noise_ = kept * noise_ + square(from.sigma_xy, from.sigma_theta) + square(to.sigma_xy, to.sigma_theta);
  for (std::size_t k = 0; k < delays; ++k) {
    const double delay = seconds(k);
    Measurement before = from;
    before.captured_at -= delay;
    errors_[k] = kept * errors_[k] + between(filter.predict(before, to.captured_at - delay), to.pose);
  }
}

std::optional<double> DelayWatch::late() const noexcept {
  constexpr double enough = 1e-3;   // ten sights that are 10 mm off [m^2]
  constexpr double little = 0.1;    // of what is seen, and of the error without a delay, may remain unexplained
  constexpr std::size_t least = 3;  // 0.3 s: motors and slow links explain less
  const auto best = std::min_element(errors_.begin(), errors_.end());
  const auto steps = static_cast<std::size_t>(best - errors_.begin());
  const double error = errors_[0] - noise_;
  // Robots that stand whatever they are commanded to may be late by any time, or never drive.
  if (steps < least || error < std::max(enough, 4.0 * noise_) || moved_ < enough ||
      *best - noise_ > little * std::min(error, moved_))
    return std::nullopt;
  return seconds(steps);
}

}  // namespace skein::core
