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
  stands(j, x, y);
  leaves(j, seconds);
}

void Traffic::leaves(std::size_t j, double seconds) noexcept {
  constexpr double nowhere = 1e6;  // [m]
  const auto first = std::min(steps - 1, static_cast<std::size_t>(seconds / step) + 1);
  std::fill(x_.begin() + static_cast<std::ptrdiff_t>(j * steps + first),
            x_.begin() + static_cast<std::ptrdiff_t>((j + 1) * steps), nowhere);
  still_from_[j] = first;
}

void Traffic::shift(std::size_t j, double x, double y, double seconds) noexcept {
  for (std::size_t k = 0; k < steps && step * static_cast<double>(k) < seconds; ++k) {
    const double share = 1.0 - step * static_cast<double>(k) / seconds;
    x_[j * steps + k] += share * x;
    y_[j * steps + k] += share * y;
  }
}

void Traffic::drives(std::size_t j, const Route& route, double clock) noexcept {
  present_[j] = true;
  const double end = route.duration();
  std::size_t k = 0, segment = 0;
  for (; k < steps; ++k) {
    const double t = clock + step * static_cast<double>(k);
    const Route::Position here = route.position(t, segment);
    x_[j * steps + k] = here.x;
    y_[j * steps + k] = here.y;
    if (t >= end) break;
  }
  k = std::min(k, steps - 1);
  still_from_[j] = k;
  for (std::size_t rest = k + 1; rest < steps; ++rest) {
    x_[j * steps + rest] = x_[j * steps + k];
    y_[j * steps + rest] = y_[j * steps + k];
  }
}

void Traffic::joins(std::size_t j, const Route& route, double clock, double joins,
                    const Timetable& timetable) noexcept {
  follows(j, timetable);
  std::size_t segment = 0;
  for (std::size_t k = 0; k < steps; ++k) {
    const double at = clock + step * static_cast<double>(k);
    if (at >= joins) break;
    const Route::Position here = route.position(at, segment);
    x_[j * steps + k] = here.x;
    y_[j * steps + k] = here.y;
    still_from_[j] = std::max(still_from_[j], k + 1);
  }
}

void Traffic::follows(std::size_t j, const Timetable& timetable) noexcept {
  const auto& [reference, t, horizon, delay] = timetable;
  present_[j] = true;
  const std::size_t last = std::min(steps - 1, static_cast<std::size_t>(horizon / step));
  for (std::size_t k = 0; k < steps; ++k) {
    const double at = t + step * static_cast<double>(k);
    const Pose pose = k <= last ? reference.at(j, at - delay.at(at)).pose : Pose{x(j, last), y(j, last), 0.0};
    x_[j * steps + k] = pose.x;
    y_[j * steps + k] = pose.y;
  }
  still_from_[j] = last;
  while (still_from_[j] > 0 && x(j, still_from_[j] - 1) == x(j, last) && y(j, still_from_[j] - 1) == y(j, last))
    --still_from_[j];
}

void Traffic::follows(std::size_t j, const Timetable& timetable, const Sidestep& aside) noexcept {
  follows(j, timetable);
  const double t = timetable.t;
  for (std::size_t k = 0; k < steps && t + step * static_cast<double>(k) < aside.ends(); ++k) {
    const Pose pose = aside.pose(timetable.reference, j, t + step * static_cast<double>(k));
    x_[j * steps + k] = pose.x;
    y_[j * steps + k] = pose.y;
    still_from_[j] = std::max(still_from_[j], std::min(steps - 1, k + 1));
  }
}

void Traffic::copy(std::size_t j, const Traffic& from) noexcept {
  present_[j] = from.present_[j];
  still_from_[j] = from.still_from_[j];
  const auto first = static_cast<std::ptrdiff_t>(j * steps);
  std::copy_n(from.x_.begin() + first, steps, x_.begin() + first);
  std::copy_n(from.y_.begin() + first, steps, y_.begin() + first);
}

void Traffic::copy(std::size_t j, const Traffic& from, double t, const Delay& delay) noexcept {
  copy(j, from);
  const auto last = std::min(steps - 1, static_cast<std::size_t>(std::max(0.0, delay.ends() - t) / step));
  for (std::size_t k = 0; k <= last; ++k) {
    const double at = t + step * static_cast<double>(k);
    const double behind = std::max(0.0, (at - delay.at(at) - t) / step);
    const auto before = std::min(steps - 2, static_cast<std::size_t>(behind));
    const double share = behind - static_cast<double>(before);
    x_[j * steps + k] = from.x(j, before) + share * (from.x(j, before + 1) - from.x(j, before));
    y_[j * steps + k] = from.y(j, before) + share * (from.y(j, before + 1) - from.y(j, before));
  }
  still_from_[j] = std::max(still_from_[j], last);
}

}  // namespace skein::core
