#pragma once

#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/experiment/experiment.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/frame_source.h"
#include "vision/tracker/tracker_options.h"

namespace skein::app {

/// What one camera of a run saw, with the calibration that it had then.
struct CameraFilm {
  std::unique_ptr<vision::FrameSource> source;
  vision::Calibration calibration;  ///< with a world frame
};

/// The error says why this is not a film recorded by `skein run --video`.
tl::expected<CameraFilm, std::string> open_film(const std::string& path);

/// Where other cameras saw robots, as a tracker gets it with a frame: its poses depend on this and on the pixels. A
/// line for Frame::note, and back, to the bit.
std::string note_of(std::span<const vision::SeenElsewhere> elsewhere);
std::vector<vision::SeenElsewhere> elsewhere_of(const std::string& note);
/// Instead of these, of a frame that repeats the last one's picture: the run took no pose from it.
inline constexpr const char* repeated_note = "repeated";

/// The film of each camera of an experiment: the path itself, and for the others the same with -2, -3... before its
/// end.
std::vector<std::string> film_paths(const Experiment& experiment, const std::string& path);

}  // namespace skein::app
