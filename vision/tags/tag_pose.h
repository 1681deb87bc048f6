#pragma once

#include <Eigen/Core>

#include "core/estimation/measurement.h"
#include "vision/tags/detection.h"

namespace skein::vision {

using core::How;

/// Where a tag is in the world.
struct TagPose {
  int tag = 0;
  core::Pose pose;           // centre of the tag [m], heading along its x axis (from its left edge to its right) [rad]
  double captured_at = 0.0;  // of the frame [s]
  double sigma_xy = 0.0;     // standard deviation of x, and of y [m]
  double sigma_theta = 0.0;  // standard deviation of theta [rad]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of (x, y, theta) [m, rad]: what the sigmas are taken from
  How how = How::detected;
  Corners corners{};  // [px]
};

}  // namespace skein::vision
