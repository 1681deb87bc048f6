#include "core/reference/polyline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

double heading(const Point& from, const Point& to) noexcept {
  return math::atan2(to.y - from.y, to.x - from.x);
}

/// How far the line turns at point i, left positive: not at all at an end. [rad]
double turn(const std::vector<Point>& points, bool closed, std::size_t i) noexcept {
  const std::size_t n = points.size();
  if (!closed && (i == 0 || i + 1 == n)) return 0.0;
  return wrap_angle(heading(points[i], points[(i + 1) % n]) - heading(points[(i + n - 1) % n], points[i]));
}

/// How much of each side an arc of radius 1 m takes at point i. [m]
double tangent(const std::vector<Point>& points, bool closed, std::size_t i) noexcept {
  return math::tan(0.5 * std::abs(turn(points, closed, i)));
}

double side(const std::vector<Point>& points, std::size_t i) noexcept {
  const Point &from = points[i], &to = points[(i + 1) % points.size()];
  return math::hypot(to.x - from.x, to.y - from.y);
}

}  // namespace

double Polyline::largest_radius(const std::vector<Point>& points, bool closed) noexcept {
  const std::size_t n = points.size(), sides = closed ? n : n - 1;
  double radius = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sides; ++i) {
    if (side(points, i) == 0.0 || std::abs(turn(points, closed, i)) > pi - 1e-6) return 0.0;
    radius = std::min(radius, side(points, i) / (tangent(points, closed, i) + tangent(points, closed, (i + 1) % n)));
  }
  return radius;
}

Polyline::Polyline(const std::vector<Point>& points, double radius, bool closed) : closed_(closed) {
  const std::size_t n = points.size(), sides = closed ? n : n - 1;
  for (std::size_t i = 0; i < sides; ++i) {
    const std::size_t next = (i + 1) % n;
    const double theta = heading(points[i], points[next]), c = math::cos(theta), s = math::sin(theta);
    const double taken = radius * tangent(points, closed, i);
    const double left = side(points, i) - radius * tangent(points, closed, next);
    parts_.push_back({length_, {points[i].x + taken * c, points[i].y + taken * s, theta}, 0.0});
    length_ += std::max(0.0, left - taken);
    const double bend = turn(points, closed, next);
    if (bend == 0.0) continue;
    largest_curvature_ = 1.0 / radius;
    parts_.push_back(
        {length_, {points[i].x + left * c, points[i].y + left * s, theta}, std::copysign(1.0 / radius, bend)});
    length_ += radius * std::abs(bend);
  }
}

PathPoint Polyline::at(double s) const noexcept {
  s = on_path(s);
  const auto after = std::upper_bound(parts_.begin() + 1, parts_.end(), s,
                                      [](double value, const Part& part) { return value < part.from; });
  const Part& part = *(after - 1);
  return {advance(part.start, {1.0, part.curvature}, s - part.from), part.curvature};
}

}  // namespace skein::core
