#pragma once

#include <memory>

#include "core/geometry/pose.h"

namespace skein::core {

/// A point of a path: where it is, which way it runs (theta), and how it bends there.
struct PathPoint {
  Pose pose;
  double curvature = 0.0;       ///< left positive [1/m]
  double curvature_rate = 0.0;  ///< its derivative along the path [1/m^2]; 0 at a joint where the curvature jumps
};

/// A closed curve parametrised by its arc length s [m]. Heading and curvature are known at every s, so that a reference
/// on it keeps both through a stop, where (3) is undefined.
class Path {
 public:
  virtual ~Path() = default;
  /// The point at arc length s; wraps, whatever the sign and size of s.
  virtual PathPoint at(double s) const noexcept = 0;
  virtual double length() const noexcept = 0;
  /// The tightest bend, or a little more. [1/m]
  virtual double largest_curvature() const noexcept = 0;
  /// Whether the curvature is continuous. Where it jumps, the velocity of a point beside the path does too.
  virtual bool smooth() const noexcept { return true; }
};

/// Closed, counter-clockwise, centred on the origin: straights along the axes joined by quarter circles.
/// s = 0 is the start (left end) of the bottom straight. The curvature jumps at the joints.
class RoundedRectangle final : public Path {
 public:
  /// Requires 0 < 2 corner_radius <= min(width, height).
  RoundedRectangle(double width, double height, double corner_radius) noexcept;
  PathPoint at(double s) const noexcept override;
  double length() const noexcept override { return 2.0 * (horizontal_ + vertical_ + 2.0 * corner_); }
  double largest_curvature() const noexcept override { return 1.0 / radius_; }
  bool smooth() const noexcept override { return false; }

 private:
  double width_, height_, radius_;
  double horizontal_, vertical_, corner_;  // arc lengths of a straight along x, along y, and of a corner
};

/// s wrapped to [0, length).
double wrap_length(double s, double length) noexcept;

/// Closed, counter-clockwise, centred on the origin; s = 0 is its rightmost point.
class Circle final : public Path {
 public:
  explicit Circle(double radius) noexcept : radius_(radius) {}
  PathPoint at(double s) const noexcept override;
  double length() const noexcept override { return 2.0 * pi * radius_; }
  double largest_curvature() const noexcept override { return 1.0 / radius_; }

 private:
  double radius_;
};

}  // namespace skein::core
