#include "core/planning/traffic.h"

#include <algorithm>

namespace skein::core {

void Traffic::stands(std::size_t j, double x, double y) noexcept {
  present_[j] = true;
  still_from_[j] = 0;
  std::fill_n(x_.begin() + static_cast<std::ptrdiff_t>(j * steps), steps, x);
  std::fill_n(y_.begin() + static_cast<std::ptrdiff_t>(j * steps), steps, y);
}

void Traffic::stands(std::size_t j, double x, double y, double seconds) noexcept {
  constexpr double nowhere = 1e6;  // [m]
  stands(j, x, y);
  const auto leaves = std::min(steps - 1, static_cast<std::size_t>(seconds / step) + 1);
  std::fill(x_.begin() + static_cast<std::ptrdiff_t>(j * steps + leaves),
            x_.begin() + static_cast<std::ptrdiff_t>((j + 1) * steps), nowhere);
  still_from_[j] = leaves;
}

void Traffic::drives(std::size_t j, const Route& route, double clock) noexcept {
  present_[j] = true;
  const double end = route.duration();
  std::size_t k = 0;
  for (; k < steps; ++k) {
    const double t = clock + step * static_cast<double>(k);
    const Pose pose = route.at(t).pose;
    x_[j * steps + k] = pose.x;
    y_[j * steps + k] = pose.y;
    if (t >= end) break;
  }
  k = std::min(k, steps - 1);
  still_from_[j] = k;
  for (std::size_t rest = k + 1; rest < steps; ++rest) {
    x_[j * steps + rest] = x_[j * steps + k];
    y_[j * steps + rest] = y_[j * steps + k];
  }
}

void Traffic::follows(std::size_t j, const Reference& reference, double t, double horizon) noexcept {
  present_[j] = true;
  const std::size_t last = std::min(steps - 1, static_cast<std::size_t>(horizon / step));
  for (std::size_t k = 0; k < steps; ++k) {
    const Pose pose =
        k <= last ? reference.at(j, t + step * static_cast<double>(k)).pose : Pose{x(j, last), y(j, last), 0.0};
    x_[j * steps + k] = pose.x;
    y_[j * steps + k] = pose.y;
  }
  still_from_[j] = last;
  while (still_from_[j] > 0 && x(j, still_from_[j] - 1) == x(j, last) && y(j, still_from_[j] - 1) == y(j, last))
    --still_from_[j];
}

}  // namespace skein::core
