#include "core/avoidance/potential_field.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"

namespace skein::core {

double region_level(const AvoidanceParameters& a, double dx, double dy) noexcept {
  return math::pow(std::abs(dx / a.alpha), a.p) + math::pow(std::abs(dy / a.beta), a.p);
}

double potential(const AvoidanceParameters& a, double x, double y, double x_ref, double y_ref, double x_j,
                 double y_j) noexcept {
  const double level = region_level(a, x - x_j, y - y_j);
  if (level > 1.0) return 0.0;
  const double ex = x - x_ref, ey = y - y_ref;
  return a.K_a * (ex * ex + ey * ey) + a.K_o * math::exp(-level / a.p);
}

Velocity descent(const AvoidanceParameters& a, double x, double y, double x_ref, double y_ref, double x_j,
                 double y_j) noexcept {
  const double dx = x - x_j, dy = y - y_j;
  const double level = region_level(a, dx, dy);
  if (level > 1.0) return {};
  const double height = a.K_o * math::exp(-level / a.p);
  const auto slope = [&](double d, double size) {
    return std::copysign(height / size * math::pow(std::abs(d / size), a.p - 1), d);
  };
  return {-2.0 * a.K_a * (x - x_ref) + slope(dx, a.alpha), -2.0 * a.K_a * (y - y_ref) + slope(dy, a.beta)};
}

namespace {
constexpr double least = 1e-3;  // [m]: a region smaller than a robot around a pole still has a size
}

AvoidanceParameters wider(const AvoidanceParameters& parameters, double by) noexcept {
  AvoidanceParameters region = parameters;
  region.alpha = std::max(least, region.alpha + by);
  region.beta = std::max(least, region.beta + by);
  return region;
}

AvoidanceParameters around(const AvoidanceParameters& parameters, const Obstacle& obstacle) noexcept {
  AvoidanceParameters wider = parameters;
  wider.alpha = std::max(least, wider.alpha + obstacle.radius - standard_radius);
  wider.beta = std::max(least, wider.beta + obstacle.radius - standard_radius);
  return wider;
}

}  // namespace skein::core
