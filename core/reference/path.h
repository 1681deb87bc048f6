#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/geometry/pose.h"

namespace skein::core {

/// A point of a path: position, direction (theta) and curvature.
struct PathPoint {
  Pose pose;
  double curvature = 0.0;       ///< left positive [1/m]
  double curvature_rate = 0.0;  ///< its derivative along the path [1/m^2]; 0 at a joint where the curvature jumps
};

/// s wrapped to [0, length).
double wrap_length(double s, double length) noexcept;

/// A curve parametrised by its arc length s [m], closed or open. Heading and curvature are known at every s, so that a
/// reference on it keeps both through a stop, where (3) is undefined.
class Path {
 public:
  virtual ~Path() = default;
  /// The point at arc length s, whatever its sign and size: a closed path wraps it, an open one holds it at its ends.
  virtual PathPoint at(double s) const noexcept = 0;
  virtual double length() const noexcept = 0;
  /// The tightest bend, or a little more. [1/m]
  virtual double largest_curvature() const noexcept = 0;
  /// Whether the curvature is continuous. Where it jumps, the velocity of a point beside the path does too.
  virtual bool smooth() const noexcept { return true; }
  virtual bool closed() const noexcept { return true; }

 protected:
  /// The arc length that `at` uses for s.
  double on_path(double s) const noexcept { return closed() ? wrap_length(s, length()) : std::clamp(s, 0.0, length()); }
};

inline constexpr std::size_t line_parts = 720;  ///< under 6 mm on the paper's lap
/// A path as a line to draw: `parts` + 1 of its poses.
std::vector<Pose> sampled(const Path& path, std::size_t parts);

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

/// Another path, moved by (x, y) [m].
class MovedPath final : public Path {
 public:
  MovedPath(std::shared_ptr<const Path> path, double x, double y) noexcept : path_(std::move(path)), x_(x), y_(y) {}
  PathPoint at(double s) const noexcept override {
    PathPoint point = path_->at(s);
    point.pose.x += x_;
    point.pose.y += y_;
    return point;
  }
  double length() const noexcept override { return path_->length(); }
  double largest_curvature() const noexcept override { return path_->largest_curvature(); }
  bool smooth() const noexcept override { return path_->smooth(); }
  bool closed() const noexcept override { return path_->closed(); }

 private:
  std::shared_ptr<const Path> path_;
  double x_, y_;
};

}  // namespace skein::core
