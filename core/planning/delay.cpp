#include "core/planning/delay.h"

#include <algorithm>

namespace skein::core {

Delay::Delay(double begins, double stands, double hurry, double slope) noexcept {
  const double stops = 1.0 / slope, sets_off = (1.0 + hurry) / slope, slows = hurry / slope;
  // Area above and below zero: what is lost while stopping, standing and setting off is caught up.
  const double lost = 0.5 * stops + stands + 0.5 / slope, gained = 0.5 * hurry * (hurry / slope + slows);
  const double hurries = std::max(0.0, lost - gained) / hurry;
  const double slopes[most] = {0.0, 1.0, 1.0, -hurry, -hurry, 0.0};
  const double lasts[most] = {stops, stands, sets_off, hurries, slows, 0.0};
  double t = begins, at = 0.0;
  for (std::size_t k = 0; k < most; ++k) {
    knots_[k] = {t, slopes[k], at};
    if (k + 1 < most) at += 0.5 * (slopes[k] + slopes[k + 1]) * lasts[k];
    t += lasts[k];
  }
  most_behind_ = lost;
}

std::size_t Delay::knot(double t) const noexcept {
  std::size_t k = 0;
  while (k + 2 < most && knots_[k + 1].t <= t) ++k;
  return k;
}

double Delay::at(double t) const noexcept {
  if (t <= begins() || t >= ends()) return 0.0;
  const Knot &a = knots_[knot(t)], &b = knots_[knot(t) + 1];
  const double since = t - a.t, lasts = b.t - a.t;
  if (!(lasts > 0.0)) return std::max(0.0, b.at);
  return std::max(0.0, a.at + since * (a.slope + 0.5 * (b.slope - a.slope) * since / lasts));
}

double Delay::rate(double t) const noexcept {
  if (t <= begins() || t >= ends()) return 1.0;
  const Knot &a = knots_[knot(t)], &b = knots_[knot(t) + 1];
  const double lasts = b.t - a.t;
  return 1.0 - (lasts > 0.0 ? a.slope + (b.slope - a.slope) * (t - a.t) / lasts : b.slope);
}

}  // namespace skein::core
