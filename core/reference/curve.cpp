#include "core/reference/curve.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"

namespace skein::core {
namespace {

// Gauss-Legendre with five nodes, on [0, 1]: exact for polynomials of degree 9.
constexpr std::array<double, 5> nodes{0.046910077030668004, 0.23076534494715845, 0.5, 0.76923465505284155,
                                      0.953089922969332};
constexpr std::array<double, 5> weights{0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                        0.23931433524968324, 0.11846344252809454};

}  // namespace

double Curve::speed(double u) const noexcept {
  const Point d = derivatives(u)[1];
  return math::hypot(d.x, d.y);
}

double Curve::length_between(double from, double to) const noexcept {
  double sum = 0.0;
  for (std::size_t k = 0; k < nodes.size(); ++k) sum += weights[k] * speed(from + nodes[k] * (to - from));
  return sum * (to - from);
}

void Curve::tabulate(double end, std::size_t cells) {
  cell_ = end / static_cast<double>(cells);
  lengths_.assign(1, 0.0);
  for (std::size_t k = 0; k < cells; ++k) {
    const double from = static_cast<double>(k) * cell_;
    lengths_.push_back(lengths_.back() + length_between(from, from + cell_));
  }
  constexpr int parts = 8;
  for (std::size_t k = 0; k < cells; ++k)
    for (int part = 0; part < parts; ++part)
      largest_curvature_ =
          std::max(largest_curvature_,
                   std::abs(point((static_cast<double>(k) + static_cast<double>(part) / parts) * cell_).curvature));
  largest_curvature_ *= 1.0001;  // the maximum may lie between two of these points
}

PathPoint Curve::point(double u) const noexcept {
  const auto [p, d, dd, ddd] = derivatives(u);
  const double square = d.x * d.x + d.y * d.y, v = std::sqrt(square);
  const double cross = d.x * dd.y - dd.x * d.y;
  const double curvature = cross / (square * v);
  const double cross_rate = d.x * ddd.y - ddd.x * d.y;  // by u
  const double rate = (cross_rate - 3.0 * cross * (d.x * dd.x + d.y * dd.y) / square) / (square * square);
  return {{p.x, p.y, wrap_angle(math::atan2(d.y, d.x))}, curvature, rate};
}

PathPoint Curve::at(double s) const noexcept {
  s = on_path(s);
  const auto above = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, s);
  const auto k = static_cast<std::size_t>(above - lengths_.begin()) - 1;
  const double from = static_cast<double>(k) * cell_, in_cell = s - lengths_[k];
  double u = from + cell_ * in_cell / (lengths_[k + 1] - lengths_[k]);
  for (int step = 0; step < 2; ++step)  // from 1e-4 of a cell to 1e-8 to the last digit
    u = std::clamp(u - (length_between(from, u) - in_cell) / speed(u), from, from + cell_);
  return point(u);
}

Ellipse::Ellipse(double width, double height) : a_(0.5 * width), b_(0.5 * height) {
  tabulate(2.0 * pi, 512);
}

Curve::Derivatives Ellipse::derivatives(double u) const noexcept {
  const auto [s, c] = math::sincos(u);
  return {{{a_ * c, b_ * s}, {-a_ * s, b_ * c}, {-a_ * c, -b_ * s}, {a_ * s, -b_ * c}}};
}

Lemniscate::Lemniscate(double width, double height) : a_(0.5 * width), b_(0.5 * height) {
  tabulate(2.0 * pi, 512);
}

Curve::Derivatives Lemniscate::derivatives(double u) const noexcept {
  const double c = math::cos(u), s = math::sin(u), c2 = math::cos(2.0 * u), s2 = math::sin(2.0 * u);
  return {{{a_ * c, b_ * s2}, {-a_ * s, 2.0 * b_ * c2}, {-a_ * c, -4.0 * b_ * s2}, {a_ * s, -8.0 * b_ * c2}}};
}

Spline::Spline(const std::vector<Point>& points, bool closed) : closed_(closed) {
  const std::size_t n = points.size(), chords = closed ? n : n - 1;
  std::vector<double> h(chords);  // the chord from each point to the next
  for (std::size_t i = 0; i < chords; ++i) {
    const Point &from = points[i], &to = points[(i + 1) % n];
    h[i] = math::hypot(to.x - from.x, to.y - from.y);
  }
  // The slopes m at the points that make the second derivative continuous:
  //   m_{i-1}/h_{i-1} + 2 m_i (1/h_{i-1} + 1/h_i) + m_{i+1}/h_i = 3 (D_{i-1}/h_{i-1} + D_i/h_i),  D the chords' slopes.
  // At an end of an open one the second derivative is 0, which takes the other chord's terms away. Diagonally dominant
  // by a factor of two, so that a hundred sweeps of Gauss-Seidel leave 1e-30.
  std::vector<Point> m(n);
  for (int sweep = 0; sweep < 100; ++sweep)
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t before = (i + n - 1) % n, after = (i + 1) % n;
      const double p = closed || i > 0 ? 1.0 / h[before] : 0.0, q = closed || i + 1 < n ? 1.0 / h[i] : 0.0;
      const auto slope = [&](double Point::*part) {
        const double known =
            3.0 * (p * p * (points[i].*part - points[before].*part) + q * q * (points[after].*part - points[i].*part));
        return (known - p * m[before].*part - q * m[after].*part) / (2.0 * (p + q));
      };
      m[i] = {slope(&Point::x), slope(&Point::y)};
    }
  for (std::size_t i = 0; i < chords; ++i) {
    const std::size_t after = (i + 1) % n;
    Piece piece;
    for (double Point::*part : {&Point::x, &Point::y}) {
      const double start = points[i].*part, way = points[after].*part - start;
      const double first = m[i].*part * h[i], last = m[after].*part * h[i];
      piece.a.*part = start;
      piece.b.*part = first;
      piece.c.*part = 3.0 * way - 2.0 * first - last;
      piece.d.*part = first + last - 2.0 * way;
    }
    pieces_.push_back(piece);
  }
  tabulate(static_cast<double>(chords), 32 * chords);
}

Curve::Derivatives Spline::derivatives(double u) const noexcept {
  const auto i = std::min(static_cast<std::size_t>(u), pieces_.size() - 1);
  const Piece& piece = pieces_[i];
  const double w = u - static_cast<double>(i);
  const auto each = [w](double a, double b, double c, double d) {
    return std::array{a + w * (b + w * (c + w * d)), b + w * (2.0 * c + 3.0 * w * d), 2.0 * c + 6.0 * w * d, 6.0 * d};
  };
  const auto x = each(piece.a.x, piece.b.x, piece.c.x, piece.d.x);
  const auto y = each(piece.a.y, piece.b.y, piece.c.y, piece.d.y);
  return {{{x[0], y[0]}, {x[1], y[1]}, {x[2], y[2]}, {x[3], y[3]}}};
}

}  // namespace skein::core
