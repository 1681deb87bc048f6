#pragma once

#include <vector>

#include "core/reference/curve.h"

namespace skein::core {

/// Straights between points, in their order and back to the first, each corner blended by an arc: the curvature, and
/// with it omega_ref, jumps where they join. s = 0 is where the first point's arc ends.
class Polyline final : public Path {
 public:
  /// Requires at least 3 points and 0 < radius <= largest_radius(points).
  Polyline(const std::vector<Point>& points, double radius);
  PathPoint at(double s) const noexcept override;
  double length() const noexcept override { return length_; }
  double largest_curvature() const noexcept override { return 1.0 / radius_; }
  bool smooth() const noexcept override { return false; }

  /// The largest radius for which the arcs at both ends of every side have room on it; 0 where the line turns back on
  /// itself or two neighbouring points coincide. [m]
  static double largest_radius(const std::vector<Point>& points) noexcept;

 private:
  /// A straight (curvature 0) or an arc, from `start` on.
  struct Part {
    double from;  // arc length
    Pose start;
    double curvature;
  };
  double radius_, length_ = 0.0;
  std::vector<Part> parts_;
};

}  // namespace skein::core
