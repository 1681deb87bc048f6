#include "core/reference/formation.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/reference/blend.h"

namespace skein::core {

Shape make_shape(ShapeName name, std::size_t robots, double spacing) {
  Shape shape;
  const std::size_t on_a_side = (robots + 3) / 4;  // of the diamond
  const double around = 2.0 * pi / static_cast<double>(std::max<std::size_t>(robots, 1));
  for (std::size_t i = 0; i < robots; ++i) {
    const auto k = static_cast<double>(i);
    switch (name) {
      case ShapeName::line:
        shape.push_back({0.0, -k * spacing});
        break;
      case ShapeName::column:
        shape.push_back({-k * spacing, 0.0});
        break;
      case ShapeName::diamond: {
        const Point corners[] = {{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}, {1.0, 0.0}};
        const Point &from = corners[i / on_a_side], &to = corners[i / on_a_side + 1];
        const double share = static_cast<double>(i % on_a_side) / static_cast<double>(on_a_side);
        const double corner = spacing * static_cast<double>(on_a_side) / std::sqrt(2.0);
        shape.push_back({corner * (from.x + share * (to.x - from.x)), corner * (from.y + share * (to.y - from.y))});
        break;
      }
      case ShapeName::v: {
        const std::size_t rows_behind = (i + 1) / 2;
        const double rank = static_cast<double>(rows_behind) * spacing / std::sqrt(2.0);
        shape.push_back({-rank, i % 2 ? rank : -rank});
        break;
      }
      case ShapeName::circle: {
        const double radius = robots > 1 ? 0.5 * spacing / math::sin(0.5 * around) : 0.0;
        shape.push_back({radius * math::cos(k * around), radius * math::sin(k * around)});
        break;
      }
    }
  }
  Point mean;
  for (const Point& p : shape) mean.x += p.x / static_cast<double>(robots), mean.y += p.y / static_cast<double>(robots);
  for (Point& p : shape) p.x -= mean.x, p.y -= mean.y;
  return shape;
}

Formation::Place Formation::place(std::size_t i, double t) const noexcept {
  const Shape* from = &shape_;
  for (const ShapeChange& change : changes_) {
    if (t <= change.t) break;
    if (t < change.t + change.duration) {
      const auto [share, rate, rate_rate] = blend(t - change.t, change.duration);
      const Point &a = (*from)[i], &b = change.shape[i];
      const double x = b.x - a.x, y = b.y - a.y;
      return {{a.x + share * x, a.y + share * y}, {rate * x, rate * y}, {rate_rate * x, rate_rate * y}};
    }
    from = &change.shape;
  }
  return {(*from)[i], {}, {}};
}

ReferencePoint Formation::at(const PathPoint& centre, const Place& p) const noexcept {
  const auto [sine, c] = math::sincos(centre.pose.theta);
  const double x = p.place.x, y = p.place.y;
  const Pose there{centre.pose.x + c * x - sine * y, centre.pose.y + sine * x + c * y, centre.pose.theta};

  // The robot's velocity and acceleration less the frame's own turning, both in the centre's frame.
  const double omega = speed_ * centre.curvature, omega_rate = speed_ * speed_ * centre.curvature_rate;
  const double v_x = speed_ - omega * y + p.velocity.x, v_y = omega * x + p.velocity.y;
  const double a_x = -omega_rate * y - omega * p.velocity.y + p.acceleration.x;
  const double a_y = omega_rate * x + omega * p.velocity.x + p.acceleration.y;
  const double square = v_x * v_x + v_y * v_y;
  if (square < 1e-24)  // it stands: its heading is the one with which it would drive on
    return {{there.x, there.y, wrap_angle(there.theta + math::atan2(centre.curvature * x, 1.0 - centre.curvature * y))},
            {}};
  return {{there.x, there.y, wrap_angle(there.theta + math::atan2(v_y, v_x))},
          {std::sqrt(square), omega + (v_x * a_y - a_x * v_y) / square}};
}

ReferencePoint Formation::at(std::size_t i, double t) const noexcept {
  return at(path_->at(start_ + speed_ * t), place(i, t));
}

void Formation::at(double t, std::span<ReferencePoint> points) const noexcept {
  const PathPoint centre = path_->at(start_ + speed_ * t);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = at(centre, place(i, t));
}

ReferenceDemand Formation::demand(double k_y) const noexcept {
  constexpr int samples = 2000;
  ReferenceDemand most;
  const auto take = [&](const ReferencePoint& point) {
    most.v = std::max(most.v, point.twist.v);
    most.turning = std::max(most.turning, std::abs(point.twist.omega) + k_y * point.twist.v);
  };
  const auto all_along = [&](const Shape& shape) {
    for (int k = 0; k < samples; ++k) {
      const PathPoint centre = path_->at(path_->length() * k / samples);
      for (const Point& place : shape) take(at(centre, Place{place, {}, {}}));
    }
  };
  all_along(shape_);
  for (const ShapeChange& change : changes_) {
    all_along(change.shape);
    for (int k = 0; k <= samples; ++k) {
      const double t = change.t + change.duration * k / samples;
      const PathPoint centre = path_->at(start_ + speed_ * t);
      for (std::size_t i = 0; i < robots(); ++i) take(at(centre, place(i, t)));
    }
  }
  return {1.001 * most.v, 1.001 * most.turning};
}

}  // namespace skein::core
