#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "vision/calibration/calibration.h"

namespace skein::vision {
namespace {

// A robot's midpoint may stand on the arena's edge: its body and the paper of its tag reach this far over it. [m]
constexpr double margin = 0.06;

constexpr double degree = std::numbers::pi / 180.0;

/// The optical axis goes through the origin; the camera is `height` above the floor.
CameraPose hang(double height) {
  Eigen::Matrix3d looking_down;
  looking_down << 1, 0, 0, 0, -1, 0, 0, 0, -1;  // u along x, v against y
  const Eigen::Matrix3d tilt = (Eigen::AngleAxisd(1.2 * degree, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(-0.8 * degree, Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(0.4 * degree, Eigen::Vector3d::UnitZ()))
                                   .toRotationMatrix();
  CameraPose pose;
  pose.rotation = tilt * looking_down;
  const Eigen::Vector3d axis = pose.rotation.col(2);
  pose.position = axis * (height / axis.z());
  return pose;
}

bool sees(const Calibration& camera, double half_width, double half_height) {
  // The picture of a straight edge bows outwards at most between its corners and its middle: look along all of it.
  constexpr int steps = 16;
  for (int i = -steps; i <= steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    const Eigen::Vector2d points[] = {{part * half_width, half_height},
                                      {part * half_width, -half_height},
                                      {half_width, part * half_height},
                                      {-half_width, part * half_height}};
    for (const Eigen::Vector2d& point : points) {
      for (const double height : {0.0, camera.tag_height}) {
        const auto pixel = pixel_from_world(camera, {point.x(), point.y(), height});
        if (!pixel || pixel->x() < 0.0 || pixel->y() < 0.0 || pixel->x() > camera.width - 1 ||
            pixel->y() > camera.height - 1) {
          return false;
        }
      }
    }
  }
  return true;
}

}  // namespace

Calibration overhead_calibration(double arena_width, double arena_height, const Eigen::Vector2d& centre) {
  Calibration camera;
  camera.width = 1280;
  camera.height = 960;
  camera.fx = 1402.0;  // a 6 mm lens over a 1/2" sensor: 49 degrees across
  camera.fy = 1400.5;
  camera.cx = 644.3;
  camera.cy = 476.1;
  camera.distortion = {-0.09, 0.03, 3e-4, -2e-4, 0.0};

  // The lowest height from which everything is seen, by bisection.
  const double half_width = arena_width / 2.0 + margin;
  const double half_height = arena_height / 2.0 + margin;
  double low = 2.0 * camera.tag_height;
  double high = 10.0 * std::max(half_width, half_height) + 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    camera.world_from_camera = hang(middle);
    (sees(camera, half_width, half_height) ? high : low) = middle;
  }
  camera.world_from_camera = hang(high);
  camera.world_from_camera->position += Eigen::Vector3d(centre.x(), centre.y(), 0.0);
  return camera;
}

Calibration tilted(Calibration calibration, double degrees) {
  calibration.world_from_camera->rotation *=
      Eigen::AngleAxisd(degrees * degree, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return calibration;
}

}  // namespace skein::vision
