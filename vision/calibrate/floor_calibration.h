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
#include "vision/frames/frame_source.h"

namespace skein::vision {

/// Looks for the marks' tags in up to `frames` frames of a source that does not move, and takes the mean of where their
/// middles were. The error: the source's, a frame of another size than the calibration's, one id seen twice.
struct FloorSight {
  int frames = 0;
  std::vector<std::vector<Eigen::Vector2d>> corners;  // of each tag in `ids`: four means [px]
  std::vector<int> ids;
};
tl::expected<FloorSight, std::string> look_at_floor(FrameSource& source, const Calibration& calibration, int frames,
                                                    const std::function<bool(int)>& keep_going = {});

/// Enters what was seen into the marks; tags that were not seen stay as they are.
void enter(const FloorSight& sight, std::vector<FloorMark>& marks);

/// How far the calibration is off at one mark: where it puts the pixel on the mark's plane, less where the mark is.
struct FloorResidual {
  const FloorMark* mark = nullptr;
  double dx = 0.0, dy = 0.0;  // [m]
};
struct FloorCheck {
  std::vector<FloorResidual> residuals;  // of the marks that were seen
  double rms = 0.0;                      // of the distances [m]
  double worst = 0.0;                    // [m]
};
tl::expected<FloorCheck, std::string> check_floor(const Calibration& calibration, const std::vector<FloorMark>& marks);

/// The world frame from four marks and more that were seen, not all on one line; the intrinsics stay.
tl::expected<Calibration, std::string> solve_floor(const Calibration& intrinsics, const std::vector<FloorMark>& marks);

/// The mark without which the others agree at least three times better: its place was measured or typed wrongly. Needs
/// six marks and more.
const FloorMark* suspect(const Calibration& intrinsics, const std::vector<FloorMark>& marks);

/// A solution that one wrong mark does not spoil.
struct TrustedFloor {
  Calibration calibration{};
  const FloorMark* left_out = nullptr;  // of `marks`: not used, since the others agree without it
  double off = 0.0;                     // how far from where it was said to be the picture shows it [m]
};
/// solve_floor, without the suspect where that is more than 5 mm off. The error: solve_floor's, or marks that disagree
/// by more than 10 mm all the same, so that any solution would be a guess.
tl::expected<TrustedFloor, std::string> solve_trusted_floor(const Calibration& intrinsics,
                                                            const std::vector<FloorMark>& marks);

/// The marks for the file of a calibration that they have led to: without the one that was left out, each tag with the
/// size that the picture shows.
std::vector<FloorMark> kept_marks(const TrustedFloor& floor, const std::vector<FloorMark>& marks,
                                  const FloorSight& sight);

/// How far poses move when a calibration is replaced: where the new one puts what the old one puts at a place, both on
/// the plane of the robots' tags.
struct PoseShift {
  struct Place {
    const char* name = "";
    double x = 0.0, y = 0.0;    // by the old one [m]
    double dx = 0.0, dy = 0.0;  // by the new one, less that [m]
  };
  std::array<Place, 5> places;  // the centre of the marks' rectangle, and its corners
  double rms = 0.0;             // of the distances, over the rectangle [m]
};
/// None where the old one has no world frame, or does not see the whole rectangle of the new one's marks.
std::optional<PoseShift> pose_shift(const Calibration& before, const Calibration& after);

/// None, or why the robots' tags cannot be as high as the calibration says: not below its camera.
std::string wrong_tag_height(const Calibration& calibration);

/// The height of the plane in which a tag that was seen would have an edge of calibration.tag_size [m]: how high the
/// robots carry theirs. None where there is no such plane between the floor and the camera.
std::optional<double> tag_height_of(const Calibration& calibration, const std::vector<Eigen::Vector2d>& corners);

}  // namespace skein::vision
