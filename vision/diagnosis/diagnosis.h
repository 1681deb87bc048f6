#pragma once

#include <Eigen/Core>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/pose.h"
#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/frames/frame.h"

namespace skein::vision {

/// Why the tracker reports no pose of a tag.
enum class NotSeen {
  not_found,     // nothing in the frame decodes as this tag
  wrong_size,    // it is there, but larger or smaller than the calibration's tag_size on the plane of the tags
  tilted,        // it is there, but no square on the plane of the tags
  doubled,       // it is there twice
  covered,       // it is there, but part of it is hidden or blurred
  at_border,     // the border of the frame cuts it, or did when it was last seen
  too_small,     // this camera gives tags of tag_size too few pixels to be decoded
  too_bright,    // much of the frame is as bright as the camera can show
  in_shadow,     // ink and paper differ by too few grey levels
  mirrored,      // the camera mirrors its frames
  other_family,  // a tag of another family has this id
};

/// A tag that was not reported.
struct MissingTag {
  int tag = 0;
  std::optional<core::Pose> last{};  // where it was last seen [m, rad]
};

struct TagDiagnosis {
  int tag = 0;
  NotSeen why = NotSeen::not_found;
  std::vector<Eigen::Vector2d> places{};  // of its middle in the world, as far as it was found [m]
  double size = 0.0;                      // its edge on the plane of the tags [m]; 0: it was not found
  double edge_px = 0.0;                   // its edge, or what it would have [px]
  double contrast = 0.0;                  // between its ink and its paper [grey levels]; 0: it was not found
  std::string family{};                   // of other_family: "25h9"
  Window crop{};                          // the part of the frame that shows it; width 0: none
};

/// Searches one frame in ways for which the tracker has no time (0.1 to 1 s at 1280x960), and says for each tag why the
/// tracker reports none. The calibration must have a world frame and hold for frames of this size.
std::vector<TagDiagnosis> diagnose(const Frame& frame, const Calibration& calibration,
                                   std::span<const MissingTag> missing);

/// One sentence without a full stop, for people: "tag 3 is there, but its edge is 40 mm, 33 % smaller than [tags] size
/// 60 mm".
std::string sentence(const TagDiagnosis& diagnosis, const Calibration& calibration);

}  // namespace skein::vision
