#include "vision/calibration/calibration.h"

#include <Eigen/LU>
#include <cmath>

namespace skein::vision {
namespace {

/// Distortion at the undistorted direction (x, y): OpenCV's model, and its Jacobian.
struct Distorted {
  Eigen::Vector2d at;
  Eigen::Matrix2d jacobian;
};

Distorted distort(const std::array<double, 5>& distortion, const Eigen::Vector2d& ray) {
  const auto [k1, k2, p1, p2, k3] = distortion;
  const double x = ray.x();
  const double y = ray.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = 2.0 * (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3));  // d radial / d r2, times 2
  Distorted result;
  result.at = {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
               y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
  const double cross = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
  result.jacobian << radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, cross,  //
      cross, radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  return result;
}

/// Inside the circle where the picture still grows outwards: beyond it the polynomial turns back, and a point far away
/// would appear in the picture a second time.
bool grows_outwards(const std::array<double, 5>& distortion, const Eigen::Vector2d& ray) {
  const double k1 = distortion[0];
  const double k2 = distortion[1];
  const double k3 = distortion[4];
  // d (r radial) / d r = 1 + 3 k1 s + 5 k2 s^2 + 7 k3 s^3 must not vanish for any s = r^2 on the way to the point.
  const double end = ray.squaredNorm();
  // Most lenses bend so little that it cannot, whatever the signs.
  if (end * (3.0 * std::abs(k1) + end * (5.0 * std::abs(k2) + end * 7.0 * std::abs(k3))) < 0.99) return true;
  constexpr int steps = 16;
  for (int i = 1; i <= steps; ++i) {
    const double s = end * i / steps;
    if (1.0 + s * (3.0 * k1 + s * (5.0 * k2 + s * 7.0 * k3)) <= 0.0) return false;
  }
  return true;
}

}  // namespace

std::optional<Eigen::Vector2d> pixel_from_world(const Calibration& calibration, const Eigen::Vector3d& point) {
  if (!calibration.world_from_camera) return std::nullopt;
  const CameraPose& world_from_camera = *calibration.world_from_camera;
  const Eigen::Vector3d in_camera = world_from_camera.rotation.transpose() * (point - world_from_camera.position);
  if (!(in_camera.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d ray = in_camera.head<2>() / in_camera.z();
  if (!grows_outwards(calibration.distortion, ray)) return std::nullopt;
  const Eigen::Vector2d at = distort(calibration.distortion, ray).at;
  return Eigen::Vector2d(calibration.fx * at.x() + calibration.cx, calibration.fy * at.y() + calibration.cy);
}

std::optional<Eigen::Vector2d> ray_from_pixel(const Calibration& calibration, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d wanted((pixel.x() - calibration.cx) / calibration.fx,
                               (pixel.y() - calibration.cy) / calibration.fy);
  // Newton's method from the distorted direction; three or four steps for any lens worth calibrating.
  Eigen::Vector2d ray = wanted;
  for (int i = 0; i < 20; ++i) {
    const Distorted distorted = distort(calibration.distortion, ray);
    const Eigen::Vector2d error = distorted.at - wanted;
    if (!(std::abs(distorted.jacobian.determinant()) > 1e-6)) return std::nullopt;
    if (error.squaredNorm() < 1e-26)
      return grows_outwards(calibration.distortion, ray) ? std::optional(ray) : std::nullopt;
    const Eigen::Matrix2d& j = distorted.jacobian;
    const Eigen::Vector2d step(j(1, 1) * error.x() - j(0, 1) * error.y(), j(0, 0) * error.y() - j(1, 0) * error.x());
    ray -= step / j.determinant();
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> world_from_pixel(const Calibration& calibration, const Eigen::Vector2d& pixel,
                                                double height) {
  if (!calibration.world_from_camera) return std::nullopt;
  const std::optional<Eigen::Vector2d> ray = ray_from_pixel(calibration, pixel);
  if (!ray) return std::nullopt;
  const CameraPose& world_from_camera = *calibration.world_from_camera;
  const Eigen::Vector3d direction = world_from_camera.rotation * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
  const double depth = (height - world_from_camera.position.z()) / direction.z();
  if (!std::isfinite(depth) || depth <= 0.0) return std::nullopt;
  return Eigen::Vector2d((world_from_camera.position + depth * direction).head<2>());
}

}  // namespace skein::vision
