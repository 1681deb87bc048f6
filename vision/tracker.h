#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "vision/calibration.h"
#include "vision/tag_plane.h"
#include "vision/tag_pose.h"

namespace skein::vision {

struct TrackerOptions {
  std::vector<int> tags{};  // ids wanted, each once; others are not reported
  int search_every = 5;     // frames between searches of the full frame while a tag is missing: a tag that left the
                            // arena for good must not cost a full search (10 ms and more) in every frame
  int audit_every = 25;     // frames between full searches when none is missing: finds a second copy of an id
  double window = 2.2;      // edge of the search window, in tag edges: a turned tag spans 1.8 with its white border
  double max_speed = 0.3;   // widens the window of a tag that was not seen for a while [m/s]; an e-puck does 0.13
  double corner_sigma = corner_sigma_px;  // noise of a corner [px]
  double shape_tolerance = 0.3;  // a tag whose edge is off by more than this part of tag_size, or whose corners are by
                                 // half of it, does not lie on a standing robot and is rejected
  int threads = 1;               // of a full search
};

/// What the tracker has done since it was made.
struct TrackerCounters {
  std::int64_t frames = 0;
  std::int64_t full_searches = 0;  // frames searched as a whole
  std::int64_t poses = 0;          // reported
  std::int64_t ghosts = 0;         // times that a wanted id was seen twice in a frame and therefore not reported
  std::int64_t rejected = 0;       // wanted tags not lying flat at tag_height, or not of tag_size
  std::int64_t wrong_frames = 0;   // frames whose size is not the calibration's: nothing is looked for in them
};

/// Frames in, poses of the wanted tags out. A tag seen before is searched in a window around its predicted place, the
/// full frame only when a wanted tag is missing. Not for two threads at once.
class TagTracker {
 public:
  /// The calibration must have a world frame (std::invalid_argument: that is the caller's mistake).
  TagTracker(Calibration calibration, TrackerOptions options);
  ~TagTracker();
  TagTracker(TagTracker&&) noexcept;
  TagTracker& operator=(TagTracker&&) noexcept;

  /// The wanted tags that this frame shows, in the order of options.tags, each at most once. Valid until the next call.
  const std::vector<TagPose>& process(const Frame& frame);

  const TrackerCounters& counters() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace skein::vision
