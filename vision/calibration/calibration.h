#pragma once

#include <Eigen/Core>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/floor_mark.h"

namespace skein::vision {

/// Where the camera is: p_world = rotation * p_camera + position.
/// World frame: x right, y up in the plane of the floor, z towards the camera; metres; the arena centred on the origin.
/// Camera frame: x right and y down in the picture, z along the optical axis, away from the lens.
struct CameraPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // its columns: the camera's axes in the world frame
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      // the lens's centre of projection [m]

  friend bool operator==(const CameraPose& a, const CameraPose& b) {
    return a.rotation == b.rotation && a.position == b.position;
  }
};

/// Edge of the black square of the tags that a robot carries, unless stated otherwise: what fits on an e-puck without a
/// plate. [m]
inline constexpr double default_tag_size = 0.04;

/// Everything needed to turn the corners of a tag (px) into a pose on the floor (m): pinhole with Brown-Conrady
/// distortion as in OpenCV, pixel (0, 0) at the centre of the top-left one.
struct Calibration {
  int width = 0;                                // size of the pictures it holds for [px]
  int height = 0;                               // [px]
  double fx = 0.0;                              // focal length in columns [px]
  double fy = 0.0;                              // focal length in rows [px]
  double cx = 0.0;                              // principal point [px]
  double cy = 0.0;                              // [px]
  std::array<double, 5> distortion{};           // k1 k2 p1 p2 k3, OpenCV's order
  double row_time = 0.0;                        // read-out time per row of a rolling shutter [s]; 0: all rows at once
  std::optional<CameraPose> world_from_camera;  // none: intrinsics only, pixels cannot be placed on the floor
  double tag_height = 0.06;                     // the plane of the tags above the floor [m]; an e-puck is 55 mm tall
  double tag_size = default_tag_size;           // edge of a tag's black square, without its white border [m]
  std::vector<FloorMark> marks{};               // from which the world frame was found; empty: not known

  double readout() const { return row_time * height; }  // from the first row to the last [s]

  friend bool operator==(const Calibration&, const Calibration&) = default;
};

/// The synthetic scene's camera: 1280x960, hung over the origin just high enough to see the whole arena (width along x,
/// height along y [m]) and the robots that stand on its edge. A degree of tilt and a lens with mild barrel distortion
/// keep the geometry from being trivial.
/// `centre`: the point over which it hangs instead, for a camera over a part of a floor [m].
Calibration overhead_calibration(double arena_width, double arena_height,
                                 const Eigen::Vector2d& centre = Eigen::Vector2d::Zero());

/// The same camera tilted about its own x axis, as a bump does. The calibration must have a world frame. [deg]
Calibration tilted(Calibration calibration, double degrees);

/// Where a world point [m] falls in the picture [px], inside it or not. None without a world frame, for a point behind
/// the lens, and for one so far off the axis that the distortion's polynomial turns back.
std::optional<Eigen::Vector2d> pixel_from_world(const Calibration& calibration, const Eigen::Vector3d& point);

/// The world point (x, y) [m] on the plane z = height [m] that a pixel sees. None without a world frame, for a ray that
/// misses the plane, and where the distortion cannot be undone.
std::optional<Eigen::Vector2d> world_from_pixel(const Calibration& calibration, const Eigen::Vector2d& pixel,
                                                double height);

/// The direction (x / z, y / z) in the camera frame that a pixel sees, distortion undone. None where the distortion
/// cannot be undone.
std::optional<Eigen::Vector2d> ray_from_pixel(const Calibration& calibration, const Eigen::Vector2d& pixel);

}  // namespace skein::vision
