#pragma once

#include <cstddef>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/tags/tag_pose.h"

namespace skein::vision {

// Cameras over one floor, each with a floor calibration of its own: where two of them see one robot at one time, their
// poses differ by what the calibrations are off. All cameras are counted from 0.

/// Two cameras, at the places where both saw one robot at one time.
struct JointPair {
  std::size_t first = 0, second = 0;  // cameras
  std::size_t places = 0;             // at least 5 mm apart, robot by robot
  std::size_t left_out = 0;           // of these: outliers, whose poses fit no correction; not counted below
  struct Apart {
    double rms = 0.0, worst = 0.0;  // of the distances between both poses [m]
    double heading = 0.0;           // rms of the headings' differences [rad]
  };
  Apart before, after;
};

struct JointCamera {
  Calibration calibration{};  // with its world frame corrected; its marks moved along with it
  double moved = 0.0;         // how far poses move, rms over the places [m]
  double known = 0.0;  // standard deviation of the correction where it is largest, in a corner of the picture [m]
  double late = 0.0;   // how late its time stamps are, against those of the reference [s]; not corrected
};

struct JointCalibration {
  std::vector<JointCamera> cameras;  // in their order; the reference as it was
  std::vector<JointPair> pairs;      // those that have places
};

/// The world frames of all cameras but `reference` that make their poses agree, by least squares with Huber's loss.
/// Shift and turn on the floor are free. Tilt and height stay near those of the calibrations, because a narrow overlap
/// determines them less well than the marks did; this limits how far poses move where no other camera looks. `sights`:
/// of each camera, in the order of their times, by the calibrations given, all on one clock. The error: a camera has no
/// world frame, heights of the tags that differ, a camera that is not tied to the reference by places that spread in
/// both directions, or poses that still differ by more than 5 mm or that fit nothing (a quarter of them).
tl::expected<JointCalibration, std::string> solve_joint(const std::vector<Calibration>& calibrations,
                                                        const std::vector<std::vector<TagPose>>& sights,
                                                        std::size_t reference = 0);

}  // namespace skein::vision
