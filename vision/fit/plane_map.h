#pragma once

#include <Eigen/Core>

#include <array>

#include "vision/calibration/calibration.h"

namespace skein::vision::detail {

/// A PlaneMap around one place, as two cubic polynomials in X and Y, along and across the heading (c, s) from there, in
/// radii. Terms in the order 1 X Y XX XY YY XXX XXY XYY YYY.
struct LocalMap {
  static constexpr std::size_t terms = 10;
  double x = 0.0;  // the place [m]
  double y = 0.0;
  double c = 1.0;  // cosine and sine of its heading
  double s = 0.0;
  double radius = 1.0;            // [m]
  std::array<double, terms> u{};  // [px]
  std::array<double, terms> v{};

  Eigen::Vector2d pixel(double px, double py) const;
  /// The smallest and the largest pixel coordinates of the four corners at X, Y = -reach, reach.
  struct Box {
    double left, right, top, bottom;
  };
  Box corners(double reach = 1.0) const;
  /// Scale in pixels per metre: the square root of the area's scale.
  double px_per_metre() const;
};

/// From the plane of the tags (world x, y [m]) to the picture [px]: perspective, then the lens. The same numbers as
/// pixel_from_world, without its checks and ten times as fast.
class PlaneMap {
 public:
  /// The plane z = tag_height of a calibration that has a world frame.
  explicit PlaneMap(const Calibration& calibration);
  /// A plane of which only a picture without distortion is known: pixel ~ homography (x, y, 1).
  explicit PlaneMap(const Eigen::Matrix3d& pixel_from_plane);

  Eigen::Vector2d pixel(double x, double y) const;

  /// The best cubic on the square of half-width `radius` around a place, turned by the heading whose cosine and sine
  /// are c and s. Tags are small where cameras see many of them: worst_error tells whether it is good enough.
  LocalMap around(double x, double y, double radius, double c = 1.0, double s = 0.0) const;

  /// The largest distance between around() and pixel() within `radius`, over the whole of a calibration's picture. [px]
  double worst_error(const Calibration& calibration, double radius) const;

 private:
  Eigen::Matrix3d ray_from_plane_;
  double fx_ = 1.0;
  double fy_ = 1.0;
  double cx_ = 0.0;
  double cy_ = 0.0;
  std::array<double, 5> distortion_{};
};

}  // namespace skein::vision::detail
