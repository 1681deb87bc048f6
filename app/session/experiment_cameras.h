#pragma once

#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "core/estimation/measurement.h"
#include "vision/calibration/calibration.h"
#include "vision/tags/tag_pose.h"

namespace skein::app {

/// The tags that an experiment looks for, those of its robots, in their order; `every`: followed by all other
/// tags.
std::vector<int> wanted_tags(const Experiment& experiment, bool every = false);
/// Updates the newest measurement of each wanted tag that was seen in a frame.
void update_newest(std::span<const vision::TagPose> seen, std::span<const int> wanted,
                   std::span<core::Measurement> newest);

/// The calibration of one of an experiment's cameras, from 0. Synthetic ones without a file share the arena: 2 side by
/// side, 4 in two rows, and each sees at least 0.2 m of its neighbour's part. The error: it is missing, wrong, or has
/// no world frame.
tl::expected<vision::Calibration, std::string> camera_calibration(const Experiment& experiment, std::size_t number = 0);

/// Whether a camera sees all of a tag at this place; nearer to the border of its picture a tag may be cut by it. [m]
bool shows_tag(const vision::Calibration& calibration, double x, double y);

/// One of several calibrations by which robots may drive before anything shows that it is another camera's.
struct UnguardedCalibration {
  std::size_t camera = 0;
  std::string sentence{};
};
/// Those that have no marks on the floor to watch. Synthetic cameras hang where their calibrations have them: none.
std::vector<UnguardedCalibration> unguarded_calibrations(const Experiment& experiment);

/// A sentence for each camera whose fx and fy differ as those of no sensor do, whose pixels are square: poses are wrong
/// by as much in one direction of its picture.
std::vector<std::string> uneven_focal_lengths(const Experiment& experiment);

/// Reads those of all cameras: what is wrong with one is to be known before a robot is reached. The error is the
/// first one's.
tl::expected<void, std::string> check_calibrations(const Experiment& experiment);

}  // namespace skein::app
