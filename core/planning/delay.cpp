#include "core/planning/delay.h"

#include <algorithm>
#include <cmath>

namespace skein::core {

Delay::Delay(const Moment& begins, double falls, double stands, double hurry, double slope) noexcept {
  // What is lost until the clock runs on time again; the way from there to `hurry` and back gains hurry^2 / slope.
  const auto area = [](double from, double to, double lasts) { return 0.5 * (from + to) * lasts; };
  const double first = std::abs(falls - begins.falls) / slope;
  const double behind = begins.behind + area(begins.falls, falls, first) + falls * stands;
  const double lost = behind + area(std::max(0.0, falls), 0.0, std::max(0.0, falls) / slope);
  hurry = std::min(hurry, std::sqrt(std::max(0.0, lost) * slope));
  const double sets_off = std::abs(falls + hurry) / slope, slows = hurry / slope;
  const double left = behind + area(falls, -hurry, sets_off) + area(-hurry, 0.0, slows);
  const double hurries = hurry > 0.0 ? std::max(0.0, left) / hurry : 0.0;
  const double slopes[most] = {begins.falls, falls, falls, -hurry, -hurry, 0.0};
  const double lasts[most] = {first, stands, sets_off, hurries, slows, 0.0};
  double t = begins.t, at = begins.behind;
  for (std::size_t k = 0; k < most; ++k) {
    knots_[k] = {t, slopes[k], at};
    if (k + 1 < most) at += area(slopes[k], slopes[k + 1], lasts[k]);
    t += lasts[k];
  }
  most_behind_ = std::max(begins.behind, lost);
}

std::size_t Delay::knot(double t) const noexcept {
  std::size_t k = 0;
  while (k + 2 < most && knots_[k + 1].t <= t) ++k;
  return k;
}

double Delay::at(double t) const noexcept {
  if (t >= ends()) return 0.0;
  if (t <= begins()) return knots_[0].at;
  const Knot &a = knots_[knot(t)], &b = knots_[knot(t) + 1];
  const double since = t - a.t, lasts = b.t - a.t;
  if (!(lasts > 0.0)) return std::max(0.0, b.at);
  return std::max(0.0, a.at + since * (a.slope + 0.5 * (b.slope - a.slope) * since / lasts));
}

double Delay::rate(double t) const noexcept {
  if (t >= ends()) return 1.0;
  if (t <= begins()) return 1.0 - knots_[0].slope;
  const Knot &a = knots_[knot(t)], &b = knots_[knot(t) + 1];
  const double lasts = b.t - a.t;
  return 1.0 - (lasts > 0.0 ? a.slope + (b.slope - a.slope) * (t - a.t) / lasts : b.slope);
}

}  // namespace skein::core
