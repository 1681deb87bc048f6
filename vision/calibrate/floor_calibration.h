#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/frames/frame.h"
#include "vision/frames/frame_source.h"

namespace skein::vision {

/// Looks for the marks' tags in up to `frames` frames of a source that does not move, and averages the positions of
/// their corners. Ends at a frame that shows one id twice. The error: the source's, a frame of another size than the
/// calibration's.
struct FloorSight {
  int frames = 0;
  std::vector<std::vector<Eigen::Vector2d>> corners;  // of each tag in `ids`: four means [px]
  std::vector<int> ids;
  std::string why_no_tag{};  // where no tag was found in any frame: see vision::why_no_tag, of the last one
  struct Seldom {
    int tag = 0, frames = 0;
  };
  std::vector<Seldom> seldom{};  // tags that were seen in fewer than half of the frames; not in `ids`
  std::vector<int> doubled{};    // tags that the last frame shows twice; not in `ids`
  Frame last{};                  // the last frame
};
tl::expected<FloorSight, std::string> look_at_floor(FrameSource& source, const Calibration& calibration, int frames,
                                                    const std::function<bool(int)>& keep_going = {});

/// Copies what was seen into the marks; marks whose tags were not seen stay unchanged.
void enter(const FloorSight& sight, std::vector<FloorMark>& marks);

/// Empty, or which tags are there twice, so that nobody knows which one of the two is meant.
std::string doubled_tags(const FloorSight& sight);

/// Why marks were not seen, and where: sentences for people, without a full stop, one for all marks that have the same
/// reason; empty: all were seen. `floor`: the calibration with the world frame that the other marks give; without a
/// world frame it is unknown where the picture should show a mark. Takes up to a second.
std::vector<std::string> why_not_seen(const FloorSight& sight, const std::vector<FloorMark>& marks,
                                      const Calibration& floor);

/// The residual of the calibration at one mark: the point that it computes from the pixel, on the mark's plane, minus
/// the mark's place.
struct FloorResidual {
  const FloorMark* mark = nullptr;
  double dx = 0.0, dy = 0.0;  // [m]
  bool left_out = false;      // it does not count in rms and worst
};
struct FloorCheck {
  std::vector<FloorResidual> residuals;  // of the marks that were seen, one that is left out as well
  std::size_t marks = 0;                 // of the marks that are not left out:
  double rms = 0.0;                      // of the distances [m]
  double worst = 0.0;                    // [m]
};
tl::expected<FloorCheck, std::string> check_floor(const Calibration& calibration, const std::vector<FloorMark>& marks,
                                                  const FloorMark* left_out = nullptr);

/// The world frame from at least four marks that were seen, not all on one line; the intrinsics stay unchanged.
tl::expected<Calibration, std::string> solve_floor(const Calibration& intrinsics, const std::vector<FloorMark>& marks);

/// The mark without which the others agree at least three times better: its place was measured or typed wrongly. Needs
/// at least six marks.
const FloorMark* suspect(const Calibration& intrinsics, const std::vector<FloorMark>& marks);

/// The error of one mark that would explain the residuals of a solution if all other marks were right: the solution
/// follows the wrong mark, with four marks so far that only a quarter of its error is left as a residual. Infinite for
/// three marks, which never disagree. [m]
double single_error(const FloorCheck& check);

/// A solution that one wrong mark does not spoil.
struct TrustedFloor {
  Calibration calibration{};
  const FloorMark* left_out = nullptr;  // of `marks`: not used, since the others agree without it
  double off = 0.0;                     // distance between its stated place and the place that the picture shows [m]
};
/// solve_floor, without the suspect where that is more than 5 mm off. The error: solve_floor's, or marks that still
/// disagree as if one of them were off by more than 10 mm (`single_error`), so that any solution would be a guess; it
/// names two marks if all agree with the places of these exchanged.
tl::expected<TrustedFloor, std::string> solve_trusted_floor(const Calibration& intrinsics,
                                                            const std::vector<FloorMark>& marks);

/// The marks to store in the calibration's file: without the one that was left out, and each tag with the size that the
/// picture shows.
std::vector<FloorMark> kept_marks(const TrustedFloor& floor, const std::vector<FloorMark>& marks,
                                  const FloorSight& sight);

/// How far poses move when a calibration is replaced: for places by the old calibration, the places by the new one,
/// both on the plane of the robots' tags.
struct PoseShift {
  struct Place {
    const char* name = "";
    double x = 0.0, y = 0.0;    // by the old one [m]
    double dx = 0.0, dy = 0.0;  // by the new one, minus the old one's [m]
  };
  std::array<Place, 5> places;  // the centre of the marks' rectangle, and its corners
  double rms = 0.0;             // of the distances, over the rectangle [m]
};
/// None where the old one has no world frame, or does not see the whole rectangle of the new one's marks.
std::optional<PoseShift> pose_shift(const Calibration& before, const Calibration& after);

/// Empty, or which of the marks that were kept has the size of no tag: then their places are in another unit.
std::string wrong_mark_size(const std::vector<FloorMark>& kept);

/// Empty, or why the robots' tags cannot be as high as the calibration says: they are not below its camera.
std::string wrong_tag_height(const Calibration& calibration);

/// The height of the plane in which a tag that was seen would have an edge of calibration.tag_size [m]: the height at
/// which the robots carry their tags. None where there is no such plane between the floor and the camera.
std::optional<double> tag_height_of(const Calibration& calibration, const std::vector<Eigen::Vector2d>& corners);

}  // namespace skein::vision
