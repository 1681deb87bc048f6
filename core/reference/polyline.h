#pragma once

#include <vector>

#include "core/reference/curve.h"

namespace skein::core {

/// Straights between points, in their order, each corner blended by an arc: the curvature, and with it omega_ref, jumps
/// where they join. Closed, it goes on to the first point again, and s = 0 is where that point's arc ends; open, it
/// runs from the first point to the last.
class Polyline final : public Path {
 public:
  /// Requires at least 3 points, 2 of an open one, and 0 < radius <= largest_radius(points, closed).
  Polyline(const std::vector<Point>& points, double radius, bool closed = true);
  PathPoint at(double s) const noexcept override;
  double length() const noexcept override { return length_; }
  double largest_curvature() const noexcept override { return largest_curvature_; }
  bool smooth() const noexcept override { return largest_curvature_ == 0.0; }
  bool closed() const noexcept override { return closed_; }

  /// The largest radius for which the arcs at both ends of every side fit on it; 0 if the line turns back on itself or
  /// two neighbouring points coincide. [m]
  static double largest_radius(const std::vector<Point>& points, bool closed = true) noexcept;

 private:
  /// A straight (curvature 0) or an arc, from `start` on.
  struct Part {
    double from;  // arc length
    Pose start;
    double curvature;
  };
  bool closed_;
  double length_ = 0.0, largest_curvature_ = 0.0;
  std::vector<Part> parts_;
};

}  // namespace skein::core
