#pragma once

#include <Eigen/Core>

#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "core/estimation/not_seen.h"
#include "core/geometry/pose.h"
#include "vision/calibration/calibration.h"
#include "vision/detector/detector.h"
#include "vision/frames/frame.h"

namespace skein::vision {

using core::NotSeen;

/// A tag of 8 modules needs so many pixels from edge to edge to be decoded.
inline constexpr double least_edge_px = 10.0;

/// A tag that was not reported.
struct MissingTag {
  int tag = 0;
  std::optional<core::Pose> last{};     // where it was last seen [m, rad]
  std::optional<double> lifted_from{};  // TagTracker::lifted_from
  std::optional<double> blur{};         // of a lens that is out of focus [px]
  std::optional<FloorMark> mark{};      // of a mark on the floor, which is no robot's tag; size 0: any is right
};

struct TagDiagnosis {
  int tag = 0;
  NotSeen why = NotSeen::not_found;
  std::vector<Eigen::Vector2d> places{};     // of its middle in the world, as far as it was found [m]
  std::vector<Eigen::Vector2d> pixels{};     // the same in the frame [px]
  double above = 0.0;                        // of lifted: height above the others, or above where it was [m]
  double printed = 0.0;                      // of lifted: its edge, if it lies no higher; 0: it was seen before [m]
  double change = 0.0;                       // of lifted: how much larger it looks than it did; 0: than the others
  double size = 0.0;                         // its edge on the plane of the tags [m]; 0: it was not found
  bool others_fit = false;                   // two and more of the tags that were not asked about have [tags] size
  double edge_px = 0.0;                      // its edge, or what it would have [px]
  double contrast = 0.0;                     // between its ink and its paper [grey levels]; 0: it was not found
  double edge_width = 0.0;                   // of blurred: of the frame's edges, from dark to bright; 0: not known [px]
  std::string family{};                      // of other_family and mirrored: "25h9", "ArUco 4x4", "36h11 in negative"
  std::vector<Window> crops{};               // the parts of the frame that show it, or where it was last seen
  std::optional<FloorMark> mark{};           // MissingTag::mark
  std::optional<Eigen::Vector2d> mark_at{};  // where a frame that were large enough would show its place [px]
  bool outside = false;                      // of a mark at_border: all of it
  std::optional<int> other{};                // id of another tag that lies in its place
  bool bare = false;                         // of covered: all of it is there, but no white border is around it
  bool partly = false;                       // of too_bright or in_shadow: only a part of the tag
};

/// Answers before the part that takes longest: tags that were never seen may be found there yet.
using DiagnosesSoFar = std::function<void(const std::vector<TagDiagnosis>&)>;

/// Searches one frame with methods that are too slow for the tracker (0.1 to 1 s at 1280x960, up to 2 s for tags never
/// seen), and says for each tag why the tracker reports none. Where a mark on the floor should be, the frame is judged
/// by what it shows there. The calibration must hold for frames of this size and have a world frame; without one only
/// marks may be asked about, and neither their places nor their sizes are judged. A mark of no size of its own is
/// expected to be of tag_size. `so_far` is called at most once. At a stop
/// tags that were never seen are looked for no longer.
std::vector<TagDiagnosis> diagnose(const Frame& frame, const Calibration& calibration,
                                   std::span<const MissingTag> missing, const DiagnosesSoFar& so_far = {},
                                   const std::stop_token& stop = {});

/// Its crops side by side, as the frame shows them; width 0: it has none.
Frame picture_of(const Frame& frame, const TagDiagnosis& diagnosis);

/// Why no tag of 36h11 was found in a frame, and what to do: "tags 1, 2, 3, 4 are mirrored: switch the camera's mirror
/// off", "no tag is of the family 36h11, but 4 look like 25h9 (1, 2, 3, 4): print them anew in 36h11", "... like ArUco
/// 4x4 ...", "the picture is blurred ..."; empty: there is none. As slow as `diagnose`.
std::string why_no_tag(const Frame& frame);

/// One sentence without a full stop, for people: "tag 3 is there, but its edge is 40 mm, 33 % smaller than [tags] size
/// 60 mm". Of a mark: "mark 24 is not seen: part of it is covered or blurred at (0.10, 0.30) m, pixel (640, 480): clear
/// it".
std::string sentence(const TagDiagnosis& diagnosis, const Calibration& calibration);

/// The same of several marks, each once: those that have the same reason share a sentence ("marks 20, 21 are not seen:
/// ...").
std::vector<std::string> mark_sentences(std::span<const TagDiagnosis> marks, const Calibration& calibration);

/// Tags, no marks, that are not found since a frame is soft (NotSeen::blurred).
struct SoftPicture {
  std::string name{};  // of its file; empty: it has none
  std::vector<TagDiagnosis> tags{};
};

/// Pictures that lack the same tags share a sentence: "a.png, b.png: none of tags 1, 2 is found, and the pictures are
/// blurred (their edges are 4.1 to 5.0 px wide, ..."; of more than 3: "12 pictures from a.png to l.png: ...".
std::vector<std::string> soft_sentences(std::span<const SoftPicture> pictures);

}  // namespace skein::vision
