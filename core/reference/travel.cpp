#include "core/reference/travel.h"

#include <algorithm>
#include <cmath>

namespace skein::core {

double SmoothStep::at(double t) const noexcept {
  const double w = duration > 0.0 ? std::clamp(t / duration, 0.0, 1.0) : (t < 0.0 ? 0.0 : 1.0);
  return height * w * w * (3.0 - 2.0 * w);
}

double SmoothStep::integral(double t) const noexcept {
  if (t <= 0.0) return 0.0;
  if (t >= duration) return height * (t - 0.5 * duration);
  const double w = t / duration;
  return height * duration * w * w * w * (1.0 - 0.5 * w);
}

// Speeding up takes T = 1.5 v / a and v T / 2 of the way, coming to rest as much.
Travel::Travel(double distance, double speed, double acceleration) noexcept : distance_(distance) {
  const double peak = std::min(speed, std::sqrt(distance * acceleration / SmoothStep::steepest));
  up_ = {peak, SmoothStep::steepest * peak / acceleration};
  cruise_ = peak > 0.0 ? std::max(0.0, distance / peak - up_.duration) : 0.0;
}

Travel Travel::within(double distance, double duration, double acceleration) noexcept {
  // distance = v (duration - T): the smaller root of 1.5 v^2 / a - v duration + distance = 0.
  const double a = SmoothStep::steepest / acceleration;
  const double root = std::sqrt(std::max(0.0, duration * duration - 4.0 * a * distance));
  return {distance, 2.0 * distance / (duration + root), acceleration};
}

double Travel::shortest(double distance, double acceleration) noexcept {
  return 2.0 * std::sqrt(SmoothStep::steepest * distance / acceleration);
}

Travel::State Travel::at(double t) const noexcept {
  if (t <= 0.0) return {};
  if (t >= duration()) return {distance_, 0.0};
  if (const double left = duration() - t; left < up_.duration) return {distance_ - up_.integral(left), up_.at(left)};
  return {up_.integral(t), up_.at(t)};
}

}  // namespace skein::core
