#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/pose.h"
#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/frames/frame.h"

namespace skein::vision::detail {

/// Where the border of a frame cuts tags that nobody has seen before: AprilTag finds whole squares only. Each of `tags`
/// (0 to largest_tag) is compared with what the frame shows along its border, at the size that the calibration
/// gives it there. Its pose [m, rad]; none: it is not there, or fewer than half of its bits are in the frame. Takes
/// some tenths of a second. The calibration must have a world frame.
std::vector<std::optional<core::Pose>> find_cut_tags(const Frame& frame, const Calibration& calibration,
                                                     std::span<const int> tags);

/// The same of tags whose middle lies in a part of a frame, and of which something covers a part, or a lamp's
/// reflection lies on it: the left, right, upper or lower half of a tag is enough. Takes up to two seconds for a
/// whole frame; at a stop it ends at once, and some are not found.
std::vector<std::optional<core::Pose>> find_covered_tags(const Frame& frame, const Calibration& calibration,
                                                         std::span<const int> tags, const Window& part,
                                                         const std::stop_token& stop = {});

}  // namespace skein::vision::detail
