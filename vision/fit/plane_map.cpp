#include "vision/fit/plane_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace skein::vision::detail {
namespace {

constexpr std::size_t side = 4;  // nodes along each axis, where Chebyshev has them: the error is spread evenly
constexpr std::size_t nodes = side * side;

using AtNodes = std::array<double, nodes>;

// -cos((i + 1/2) pi / side)
constexpr std::array<double, side> node = {-0.92387953251128674, -0.38268343236508978, 0.38268343236508978,
                                           0.92387953251128674};

/// Chebyshev's polynomials of degree 0 to 3 at these nodes are orthogonal: their coefficients along one axis.
struct Chebyshev {
  double c0, c1, c2, c3;
};

Chebyshev along(double a, double b, double c, double d) {
  const double outer = a + d, inner = b + c, far = d - a, near = c - b;
  constexpr double half_root = 0.70710678118654752;  // T2 at the nodes: half_root, -half_root, -half_root, half_root
  return {0.25 * (outer + inner), 0.5 * (node[3] * far + node[2] * near), 0.5 * half_root * (outer - inner),
          0.5 * (node[2] * far - node[3] * near)};
}

/// Least squares: a product of polynomials of degree 3 and less in X and Y, cut off behind degree 3 of both together.
std::array<double, LocalMap::terms> cubic_through(const AtNodes& f) {
  std::array<Chebyshev, side> x;
  for (std::size_t row = 0; row < side; ++row)
    x[row] = along(f[4 * row], f[4 * row + 1], f[4 * row + 2], f[4 * row + 3]);
  const Chebyshev y0 = along(x[0].c0, x[1].c0, x[2].c0, x[3].c0);
  const Chebyshev y1 = along(x[0].c1, x[1].c1, x[2].c1, x[3].c1);
  const Chebyshev y2 = along(x[0].c2, x[1].c2, x[2].c2, x[3].c2);
  const Chebyshev y3 = along(x[0].c3, x[1].c3, x[2].c3, x[3].c3);
  // T2 = 2 X^2 - 1, T3 = 4 X^3 - 3 X
  return {y0.c0 - y2.c0 - y0.c2,
          y1.c0 - 3.0 * y3.c0 - y1.c2,
          y0.c1 - 3.0 * y0.c3 - y2.c1,
          2.0 * y2.c0,
          y1.c1,
          2.0 * y0.c2,
          4.0 * y3.c0,
          2.0 * y2.c1,
          2.0 * y1.c2,
          4.0 * y0.c3};
}

}  // namespace

Eigen::Vector2d LocalMap::pixel(double px, double py) const {
  const double dx = (px - x) / radius, dy = (py - y) / radius;
  const double X = c * dx + s * dy, Y = c * dy - s * dx;
  const auto cubic = [X, Y](const std::array<double, terms>& a) {
    return a[0] + X * (a[1] + X * (a[3] + X * a[6]) + Y * (a[4] + X * a[7] + Y * a[8])) +
           Y * (a[2] + Y * (a[5] + Y * a[9]));
  };
  return {cubic(u), cubic(v)};
}

LocalMap::Box LocalMap::corners(double reach) const {
  const auto span = [r = reach, r2 = reach * reach](const std::array<double, terms>& a) {
    const double middle = a[0] + r2 * (a[3] + a[5]), slant = r2 * a[4];
    const double in_x = r * (a[1] + r2 * (a[6] + a[8])), in_y = r * (a[2] + r2 * (a[7] + a[9]));
    // At (1, 1) and (-1, -1), and at the other two.
    const double one = std::abs(in_x + in_y), other = std::abs(in_x - in_y);
    return std::array{std::min(middle + slant - one, middle - slant - other),
                      std::max(middle + slant + one, middle - slant + other)};
  };
  const auto [left, right] = span(u);
  const auto [top, bottom] = span(v);
  return {left, right, top, bottom};
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

LocalMap PlaneMap::around(double x, double y, double radius, double c, double s) const {
  LocalMap map;
  map.x = x;
  map.y = y;
  map.c = c;
  map.s = s;
  map.radius = radius;
  // Rays are linear in X and Y.
  const Eigen::Matrix3d& h = ray_from_plane_;
  struct Ray {
    double middle, in_x, in_y;
  };
  const auto ray = [&](int i) {
    return Ray{h(i, 0) * x + h(i, 1) * y + h(i, 2), radius * (h(i, 0) * c + h(i, 1) * s),
               radius * (h(i, 1) * c - h(i, 0) * s)};
  };
  const Ray ray_a = ray(0), ray_b = ray(1), ray_depth = ray(2);
  const auto [k1, k2, p1, p2, k3] = distortion_;
  const double fx = fx_, fy = fy_, cx = cx_, cy = cy_;
  AtNodes u, v;
  for (std::size_t row = 0; row < side; ++row) {
    const double a0 = ray_a.middle + ray_a.in_y * node[row];
    const double b0 = ray_b.middle + ray_b.in_y * node[row];
    const double depth0 = ray_depth.middle + ray_depth.in_y * node[row];
    for (std::size_t column = 0; column < side; ++column) {
      const double depth = 1.0 / (depth0 + ray_depth.in_x * node[column]);
      const double a = (a0 + ray_a.in_x * node[column]) * depth;
      const double b = (b0 + ray_b.in_x * node[column]) * depth;
      const double r2 = a * a + b * b;
      const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
      u[side * row + column] = fx * (a * radial + 2.0 * p1 * a * b + p2 * (r2 + 2.0 * a * a)) + cx;
      v[side * row + column] = fy * (b * radial + p1 * (r2 + 2.0 * b * b) + 2.0 * p2 * a * b) + cy;
    }
  }
  map.u = cubic_through(u);
  map.v = cubic_through(v);
  return map;
}

double PlaneMap::worst_error(const Calibration& calibration, double radius) const {
  constexpr int grid = 8;
  constexpr int directions = 8;
  double worst = 0.0;
  for (int i = 0; i <= grid * grid + 2 * grid; ++i) {
    const int column = i % (grid + 1), row = i / (grid + 1);
    const Eigen::Vector2d seen(calibration.width * column / static_cast<double>(grid),
                               calibration.height * row / static_cast<double>(grid));
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
