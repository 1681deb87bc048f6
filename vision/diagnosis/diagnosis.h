#pragma once

#include <Eigen/Core>

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/estimation/not_seen.h"
#include "core/geometry/pose.h"
#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/frames/frame.h"

namespace skein::vision {

using core::NotSeen;

/// A tag that was not reported.
struct MissingTag {
  int tag = 0;
  std::optional<core::Pose> last{};     // where it was last seen [m, rad]
  std::optional<double> lifted_from{};  // TagTracker::lifted_from
  std::optional<double> blur{};         // of a lens that is out of focus [px]
};

struct TagDiagnosis {
  int tag = 0;
  NotSeen why = NotSeen::not_found;
  std::vector<Eigen::Vector2d> places{};  // of its middle in the world, as far as it was found [m]
  double above = 0.0;                     // of lifted: height above the others, or above where it was [m]
  double printed = 0.0;                   // of lifted: its edge, if it lies no higher; 0: it was seen before [m]
  double change = 0.0;                    // of lifted: how much larger it looks than it did; 0: than the others
  double size = 0.0;                      // its edge on the plane of the tags [m]; 0: it was not found
  bool others_fit = false;                // two and more of the tags that were not asked about have [tags] size
  double edge_px = 0.0;                   // its edge, or what it would have [px]
  double contrast = 0.0;                  // between its ink and its paper [grey levels]; 0: it was not found
  double edge_width = 0.0;                // of blurred: of the frame's edges, from dark to bright [px]
  std::string family{};                   // of other_family and mirrored: "25h9", "ArUco 4x4", "36h11 in negative"
  std::vector<Window> crops{};            // the parts of the frame that show it, or where it was last seen
};

/// Searches one frame with methods that are too slow for the tracker (0.1 to 1 s at 1280x960), and says for each tag
/// why the tracker reports none. The calibration must have a world frame and hold for frames of this size.
std::vector<TagDiagnosis> diagnose(const Frame& frame, const Calibration& calibration,
                                   std::span<const MissingTag> missing);

/// Its crops side by side, as the frame shows them; width 0: it has none.
Frame picture_of(const Frame& frame, const TagDiagnosis& diagnosis);

/// Why no tag of 36h11 was found in a frame, and what to do: "tags 1, 2, 3, 4 are mirrored: switch the camera's mirror
/// off", "no tag is of the family 36h11, but 4 look like 25h9 (1, 2, 3, 4): print them anew in 36h11", "... like ArUco
/// 4x4 ...", "the picture is blurred ..."; empty: there is none. As slow as `diagnose`.
std::string why_no_tag(const Frame& frame);

/// One sentence without a full stop, for people: "tag 3 is there, but its edge is 40 mm, 33 % smaller than [tags] size
/// 60 mm".
std::string sentence(const TagDiagnosis& diagnosis, const Calibration& calibration);

}  // namespace skein::vision
