#include "vision/fit/plane_map.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace skein::vision::detail {
namespace {

constexpr int side = 4;  // nodes along each axis, where Chebyshev has them: the error is spread evenly
constexpr int nodes = side * side;

using Terms = Eigen::Matrix<double, 1, LocalMap::terms>;
using FromNodes = Eigen::Matrix<double, LocalMap::terms, nodes>;

Terms terms_at(double x, double y) {
  Terms t;
  t << 1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return t;
}

double node(int i) {
  return -std::cos((i + 0.5) * std::numbers::pi / side);
}

/// Least squares, once and for all: polynomial = from_nodes * values at the nodes.
const FromNodes& from_nodes() {
  static const FromNodes inverse = [] {
    Eigen::Matrix<double, nodes, LocalMap::terms> rows;
    for (int i = 0; i < nodes; ++i) rows.row(i) = terms_at(node(i % side), node(i / side));
    return FromNodes(rows.completeOrthogonalDecomposition().pseudoInverse());
  }();
  return inverse;
}

}  // namespace

Eigen::Vector2d LocalMap::pixel(double px, double py) const {
  const Terms at = terms_at((px - x) / radius, (py - y) / radius);
  Eigen::Vector2d result(0.0, 0.0);
  for (std::size_t i = 0; i < terms; ++i) {
    result.x() += at[static_cast<Eigen::Index>(i)] * u[i];
    result.y() += at[static_cast<Eigen::Index>(i)] * v[i];
  }
  return result;
}

double LocalMap::px_per_metre() const {
  return std::sqrt(std::abs(u[1] * v[2] - u[2] * v[1])) / radius;
}

PlaneMap::PlaneMap(const Calibration& calibration)
    : fx_(calibration.fx),
      fy_(calibration.fy),
      cx_(calibration.cx),
      cy_(calibration.cy),
      distortion_(calibration.distortion) {
  // p_camera = R^T ((x, y, h) - position): linear in (x, y, 1).
  const CameraPose& world_from_camera = *calibration.world_from_camera;
  const Eigen::Matrix3d turn = world_from_camera.rotation.transpose();
  ray_from_plane_.col(0) = turn.col(0);
  ray_from_plane_.col(1) = turn.col(1);
  ray_from_plane_.col(2) = turn * (Eigen::Vector3d(0.0, 0.0, calibration.tag_height) - world_from_camera.position);
}

PlaneMap::PlaneMap(const Eigen::Matrix3d& pixel_from_plane) : ray_from_plane_(pixel_from_plane) {}

Eigen::Vector2d PlaneMap::pixel(double x, double y) const {
  const Eigen::Matrix3d& h = ray_from_plane_;
  const double depth = 1.0 / (h(2, 0) * x + h(2, 1) * y + h(2, 2));
  const double a = (h(0, 0) * x + h(0, 1) * y + h(0, 2)) * depth;
  const double b = (h(1, 0) * x + h(1, 1) * y + h(1, 2)) * depth;
  const auto [k1, k2, p1, p2, k3] = distortion_;
  const double r2 = a * a + b * b;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  return {fx_ * (a * radial + 2.0 * p1 * a * b + p2 * (r2 + 2.0 * a * a)) + cx_,
          fy_ * (b * radial + p1 * (r2 + 2.0 * b * b) + 2.0 * p2 * a * b) + cy_};
}

LocalMap PlaneMap::around(double x, double y, double radius) const {
  const FromNodes& inverse = from_nodes();
  LocalMap map;
  map.x = x;
  map.y = y;
  map.radius = radius;
  for (int i = 0; i < nodes; ++i) {
    const Eigen::Vector2d at = pixel(x + radius * node(i % side), y + radius * node(i / side));
    for (std::size_t k = 0; k < LocalMap::terms; ++k) {
      map.u[k] += inverse(static_cast<Eigen::Index>(k), i) * at.x();
      map.v[k] += inverse(static_cast<Eigen::Index>(k), i) * at.y();
    }
  }
  return map;
}

double PlaneMap::worst_error(const Calibration& calibration, double radius) const {
  constexpr int grid = 8;
  constexpr int directions = 8;
  double worst = 0.0;
  for (int i = 0; i <= grid * grid + 2 * grid; ++i) {
    const Eigen::Vector2d seen(calibration.width * (i % (grid + 1)) / static_cast<double>(grid),
                               calibration.height * (i / (grid + 1)) / static_cast<double>(grid));
    const auto place = world_from_pixel(calibration, seen, calibration.tag_height);
    if (!place) continue;
    const LocalMap map = around(place->x(), place->y(), radius);
    for (int k = 0; k < 2 * directions; ++k) {
      const double reach = k < directions ? radius : radius / 2.0;
      const double angle = 2.0 * std::numbers::pi * k / directions;
      const double x = place->x() + reach * std::cos(angle);
      const double y = place->y() + reach * std::sin(angle);
      worst = std::max(worst, (map.pixel(x, y) - pixel(x, y)).norm());
    }
  }
  return worst;
}

}  // namespace skein::vision::detail
