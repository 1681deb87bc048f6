#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/frames/frame_source.h"
#include "vision/recording/recorder.h"

namespace skein::vision {

struct TrackOptions {
  std::string source{};    // as for open_source
  SourceOptions camera{};  // size, rate and controls; the size is the calibration's where there is one
  std::optional<Calibration> calibration{};  // none: ids and corners in px only
  std::ostream* csv = nullptr;               // rows go here; none: only the summary is wanted
  std::int64_t max_frames = 0;               // 0: until the end of the stream; a camera has none
  double decimate = 0.0;  // as for DetectorOptions; 0: chosen so that no tag known to be readable is lost
  std::string record{};   // a film that the frames are kept in (see Recorder); empty: none
  FilmNotes notes{};      // of that film; SOURCE is added
  std::function<bool(std::int64_t frames)>
      keep_going{};  // asked after every frame, and with -1 while a camera does not deliver: false ends the run
};

struct TrackSummary {
  std::int64_t frames = 0;
  std::int64_t detections = 0;
  std::vector<std::string> skipped;  // pictures that could not be read: file and reason
  std::vector<int> ids;              // seen, ascending
  std::string why_no_tag{};          // where no tag was seen: see vision::why_no_tag, of the last frame; else empty
  std::string source{};              // FrameSource::describe()
  RecorderStatus recording{};
  SourceStatus status{};  // of the source at the end
};

/// Every tag of every frame as CSV, one row each, no control: the body of `skein track`. Columns: frame, source, t [s],
/// tag, u1 v1 .. u4 v4 [px, AprilTag's order]; with a calibration x y [m] theta [rad] sigma_xy [m] sigma_theta [rad]
/// (empty where it cannot place the tag on the floor); how. Errors: the source's, no picture that can be read, a frame
/// whose size is not the calibration's, a CSV or a film that cannot be written; a film that breaks off later is only
/// reported.
tl::expected<TrackSummary, std::string> track(const TrackOptions& options);

}  // namespace skein::vision
