#pragma once

#include <Eigen/Core>

#include <optional>

#include "core/geometry/pose.h"
#include "vision/calibration/calibration.h"
#include "vision/tags/detection.h"

namespace skein::vision {

/// The square in the tags' plane that fits a tag's four corners best.
struct TagOnPlane {
  core::Pose pose;             // centre [m] and heading [rad] in the world
  double edge = 0.0;           // of the square [m]
  double misfit = 0.0;         // rms distance of the corners from the square's [m]
  double metres_per_px = 0.0;  // at the tag
};

/// Corners in the picture -> distortion undone -> the plane z = tag_height -> the nearest square (least squares over
/// centre, heading and edge). In the plane the corners' mean is the true centre, which it is not in a picture taken at
/// an angle; and a fit in the plane has one answer, where a tag's 3-D pose flips between two when it is parallel to the
/// picture. None where a corner cannot be placed on the plane.
std::optional<TagOnPlane> place_on_plane(const Calibration& calibration, const Corners& corners);

/// The corners' mean in the picture [px].
Eigen::Vector2d middle_of(const Corners& corners);

/// The edge of a tag in the middle of the image. 0 without a world frame. [px]
double tag_edge_px(const Calibration& calibration);

/// The usual noise of a corner, in u and in v: measured with 36h11 of 38 px, sensor noise 4 of 255, blur 0.7 px.
inline constexpr double corner_sigma_px = 0.07;

/// How well a pose is known, for corners that scatter by `corner_sigma` px in u and in v.
struct PoseSigma {
  double xy = 0.0;     // [m]
  double theta = 0.0;  // [rad]
};
PoseSigma pose_sigma(const TagOnPlane& tag, double corner_sigma);

}  // namespace skein::vision
