#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/reference/path.h"

namespace skein::core {

/// A place on the floor, or a vector. [m]
struct Point {
  double x = 0.0;
  double y = 0.0;

  friend bool operator==(const Point&, const Point&) = default;
};

/// A curve given by a parameter u, reparametrised by arc length: a table of lengths at construction, then Newton's
/// method on the exact integral between two of its entries. Unit speed to about 1e-12; no allocation in `at`.
class Curve : public Path {
 public:
  PathPoint at(double s) const noexcept final;
  double length() const noexcept final { return lengths_.back(); }
  double largest_curvature() const noexcept final { return largest_curvature_; }

 protected:
  /// The point at u and its first three derivatives by u, smooth between the table's entries.
  using Derivatives = std::array<Point, 4>;
  virtual Derivatives derivatives(double u) const noexcept = 0;
  /// Must be the last call in a subclass's constructor: u runs from 0 to `end`, in `cells` equal parts.
  void tabulate(double end, std::size_t cells);

 private:
  double speed(double u) const noexcept;
  double length_between(double from, double to) const noexcept;
  PathPoint point(double u) const noexcept;

  double cell_ = 0.0;
  std::vector<double> lengths_;
  double largest_curvature_ = 0.0;
};

/// Centred on the origin, counter-clockwise; s = 0 is its rightmost point.
class Ellipse final : public Curve {
 public:
  /// The whole width and height. [m]
  Ellipse(double width, double height);

 private:
  Derivatives derivatives(double u) const noexcept override;
  double a_, b_;
};

/// A figure eight, x = width/2 cos u, y = height/2 sin 2u (Gerono's lemniscate): a bend to the left, one to the right.
/// It crosses itself at the origin; s = 0 is its rightmost point, where it runs upwards.
class Lemniscate final : public Curve {
 public:
  Lemniscate(double width, double height);

 private:
  Derivatives derivatives(double u) const noexcept override;
  double a_, b_;
};

/// A smooth curve through points, in their order: the cubic spline over the chords' lengths, its curvature continuous.
/// Closed, it goes on to the first point again (periodic); open, it is straight at both ends (natural). s = 0 is the
/// first point.
class Spline final : public Curve {
 public:
  /// Requires at least 3 points, no two neighbours at the same place.
  explicit Spline(const std::vector<Point>& points, bool closed = true);
  bool closed() const noexcept override { return closed_; }

 private:
  Derivatives derivatives(double u) const noexcept override;
  /// p(w) = a + b w + c w^2 + d w^3 for w from 0 to 1.
  struct Piece {
    Point a, b, c, d;
  };
  bool closed_;
  std::vector<Piece> pieces_;
};

}  // namespace skein::core
