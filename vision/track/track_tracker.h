#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/track/track.h"
#include "vision/tracker/tracker_options.h"

namespace skein::vision {

/// How long one frame took [s]; NaN: not known.
struct FrameLatency {
  double arrival = 0.0;  // from the camera's time stamp until its driver hands the frame over
  double grey = 0.0;     // from there, or of a film and of pictures from the start of reading, to grey levels
  double tracker = 0.0;  // from there to poses
  StageTimes stages{};   // of which the tracker's stages
};

struct TrackTrackerOptions {
  TrackOptions track{};     // with a calibration that has a world frame; `decimate` is not used
  std::vector<int> tags{};  // to follow, as a run follows its robots'; none: of a stream the tags that AprilTag finds
                            // in the first frame that shows any; of pictures, those of each
  std::function<double()> clock{};                          // [s], CLOCK_MONOTONIC for a camera; none: no latencies
  std::function<void(const FrameLatency&)> latency{};       // called for every frame
  std::function<void(const std::string& sentence)> tell{};  // why a tag is not taken, as soon as it is known;
                                                            // of soft pictures at the end, once for all
  std::string crops{};  // folder for a picture of each tag that `tell` is called for, which it then names; empty: none
};

struct TrackTrackerSummary {
  TrackSummary track{};         // its detections are poses; its ids those of tags with a pose
  std::vector<int> followed{};  // tags that were looked for, ascending
  TrackerCounters counters{};
  std::int64_t detected = 0;   // poses of tags that had not been seen before
  std::int64_t tracked = 0;    // where they were expected
  std::int64_t recovered = 0;  // elsewhere
  std::int64_t lost = 0;       // times that a tag had a pose in one frame and none in the next
};

/// Every pose of the tracker as CSV: the body of `skein track --tracker`. A tag that had no pose for half a second, and
/// one that has none at the end, is diagnosed (vision::diagnose) and reported once for each reason: on a thread of its
/// own for a camera. Of single pictures each is searched by a tracker of its own, and by one at the other resolution if
/// that has found fewer tags than AprilTag reads; tags that AprilTag reads and the tracker does not take are reported.
/// Errors: those of vision::track, and no calibration with a world frame.
tl::expected<TrackTrackerSummary, std::string> track_with_tracker(const TrackTrackerOptions& options);

}  // namespace skein::vision
