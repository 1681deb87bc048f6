#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <optional>

#include "core/geometry/pose.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/frame.h"

namespace skein::vision::detail {

/// What a frame shows of a tag whose number and place are known.
enum class TagRemains : std::uint8_t {
  none,        ///< nothing of it
  part,        ///< of a half of it, nearly all modules are there
  reflection,  ///< a reflection lies on a part of it: ink is bright there
  shadow,      ///< all of it is there, a part in a shadow
  whole,       ///< all of it is there, in even light: it is too blurred for its size, or too faint
};

/// Looks for tag `tag` with an edge of calibration.tag_size around a place on the plane of the tags, turned in any way.
/// Neighbouring modules are compared, of which light that changes over the tag leaves the order. The calibration must
/// have a world frame.
TagRemains remains_of_tag(const Frame& frame, const Calibration& calibration, const Eigen::Vector2d& place, int tag);

/// Whether no other tag agrees as well as `tag` with what a frame shows around a pose on the plane of the tags, to a
/// module and 12 degrees. `remains_of_tag` tells that there is a part of a tag, but hardly of which.
bool fits_best(const Frame& frame, const Calibration& calibration, const core::Pose& pose, int tag);

}  // namespace skein::vision::detail
