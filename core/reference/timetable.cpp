#include "core/reference/timetable.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"

namespace skein::core {

Timetable::Timetable(const std::vector<TimedPoint>& points) {
  const std::size_t n = points.size();
  for (const TimedPoint& point : points) times_.push_back(point.t);
  // The velocities m that make the acceleration continuous, as in `Spline`; none at the ends.
  std::vector<Point> m(n);
  struct Row {  // of the equations of m
    double p, q, sum;
    Point known;
  };
  std::vector<Row> rows;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double p = 1.0 / (times_[i] - times_[i - 1]), q = 1.0 / (times_[i + 1] - times_[i]);
    const auto known = [&](double Point::*part) {
      return 3.0 * (p * p * (points[i].place.*part - points[i - 1].place.*part) +
                    q * q * (points[i + 1].place.*part - points[i].place.*part));
    };
    rows.push_back({p, q, 2.0 * (p + q), {known(&Point::x), known(&Point::y)}});
  }
  bool changes = true;
  for (int sweep = 0; sweep < 100 && changes; ++sweep) {
    changes = false;
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const auto& [p, q, sum, known] = rows[i - 1];
      const Point velocity{(known.x - p * m[i - 1].x - q * m[i + 1].x) / sum,
                           (known.y - p * m[i - 1].y - q * m[i + 1].y) / sum};
      changes = changes || velocity.x != m[i].x || velocity.y != m[i].y;
      m[i] = velocity;
    }
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = times_[i + 1] - times_[i];
    Piece piece;
    for (double Point::*part : {&Point::x, &Point::y}) {
      const double mean = (points[i + 1].place.*part - points[i].place.*part) / h;
      piece.a.*part = points[i].place.*part;
      piece.b.*part = m[i].*part;
      piece.c.*part = (3.0 * mean - 2.0 * m[i].*part - m[i + 1].*part) / h;
      piece.d.*part = (m[i].*part + m[i + 1].*part - 2.0 * mean) / (h * h);
    }
    pieces_.push_back(piece);
  }
}

ReferencePoint Timetable::at(double t) const noexcept {
  const bool stands = t <= times_.front() || t >= times_.back();
  t = std::clamp(t, times_.front(), times_.back());
  const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
  const auto k = static_cast<std::size_t>(after - times_.begin()) - 1;
  const auto& [p, b, c, d] = pieces_[k];
  const double w = t - times_[k];
  const Point velocity{b.x + w * (2.0 * c.x + 3.0 * w * d.x), b.y + w * (2.0 * c.y + 3.0 * w * d.y)};
  const Point acceleration{2.0 * c.x + 6.0 * w * d.x, 2.0 * c.y + 6.0 * w * d.y};
  const Pose place{p.x + w * (b.x + w * (c.x + w * d.x)), p.y + w * (b.y + w * (c.y + w * d.y)), 0.0};
  const double square = velocity.x * velocity.x + velocity.y * velocity.y;
  constexpr double nothing = 1e-12;  // of a velocity squared: its direction is lost in rounding
  if (stands || square < nothing) {
    // Shortly after a stop the velocity points along the acceleration, shortly before one against it.
    const double sign = t >= times_.back() ? -1.0 : 1.0;
    return {{place.x, place.y, wrap_angle(math::atan2(sign * acceleration.y, sign * acceleration.x))}, {}};
  }
  return {{place.x, place.y, wrap_angle(math::atan2(velocity.y, velocity.x))},
          {std::sqrt(square), (velocity.x * acceleration.y - acceleration.x * velocity.y) / square}};
}

ReferenceDemand Timetable::demand(double k_y) const noexcept {
  constexpr int parts = 20;
  ReferenceDemand most;
  for (std::size_t k = 0; k + 1 < times_.size(); ++k)
    for (int part = 0; part <= parts; ++part) {
      const Twist twist = at(times_[k] + (times_[k + 1] - times_[k]) * part / parts).twist;
      most.v = std::max(most.v, twist.v);
      most.turning = std::max(most.turning, std::abs(twist.omega) + k_y * twist.v);
    }
  return {1.01 * most.v, 1.01 * most.turning};
}

std::vector<Pose> Timetable::line() const {
  std::vector<Pose> poses;
  for (std::size_t k = 0; k <= line_parts; ++k)
    poses.push_back(at(times_.front() + (times_.back() - times_.front()) * static_cast<double>(k) / line_parts).pose);
  return poses;
}

}  // namespace skein::core
