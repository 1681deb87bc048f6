#pragma once

#include <Eigen/Core>

#include <string_view>

#include "core/geometry/pose.h"
#include "vision/detector.h"

namespace skein::vision {

/// How a tag came to be known in this frame.
enum class How {
  detected,   // seen for the first time
  tracked,    // found where the frames before said that it would be
  recovered,  // found again after it was lost
};

constexpr std::string_view name(How how) noexcept {
  switch (how) {
    case How::tracked:
      return "tracked";
    case How::recovered:
      return "recovered";
    case How::detected:
      break;
  }
  return "detected";
}

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
