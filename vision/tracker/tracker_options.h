#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "core/geometry/pose.h"
#include "vision/tags/tag_plane.h"

namespace skein::vision {

struct TrackerOptions {
  std::vector<int> tags{};  // ids wanted, each once; others are not reported
  int search_every = 5;     // frames between AprilTag searches of the full frame (10 ms and more) while no tag was ever
                            // seen, or while one was seen twice
  int search_parts = 48;    // once a tag was seen, a missing one costs one of so many overlapping parts of the frame in
                            // every frame: a tag that is hidden or gone for good must not hold the others up
  int audit_every = 25;     // frames in which the gate, strip by strip, goes over the whole picture for second copies
  int search_anyway = 250;  // frames between two such parts when no tag is missing: for copies in deep shadow
  double window = 2.2;      // edge of the search window, in tag edges: a turned tag spans 1.8 with its white border
  double max_speed = 0.3;   // widens the window of a tag that was not seen for a while [m/s]; an e-puck does 0.13
  double corner_sigma = corner_sigma_px;  // noise of AprilTag's corners [px]
  double shape_tolerance = 0.06;  // a tag larger, smaller or more slanted than this part of its size is not where its
                                  // pose says: it is held up (10 cm under a camera at 1.7 m), tilted or misprinted
  // How much larger than the other tags, where three and more are seen, a tag on the floor may look: 27 mm under a
  // camera at 1.8 m. What is wrong with all of them is the calibration's tag_size or tag_height; a smaller tag is a
  // misprint, in its place.
  double group_tolerance = 0.015;
  double lift_tolerance = 0.012;  // as much, compared with what the tag itself has shown for the last seconds: it
                                  // was lifted, by 22 mm under a camera at 1.8 m. The picture has tilt and lens errors
                                  // of its own, but they change slowly while a robot drives
  int threads = 1;                // of a full search
  double decimate = 0.0;          // of AprilTag's searches, as for DetectorOptions; 0: as the tags' size allows
  bool baseline = false;          // only the instructions that every x86-64 has, as where there is no AVX2
  std::function<double()> clock{};  // [s]; measures the stages of each frame; none: they are not measured
};

/// A tag that another camera sees, and its pose on the floor at the time of the frame, as that camera estimates it.
struct SeenElsewhere {
  int tag = 0;
  core::Pose pose;
};

/// What the tracker does with a frame, in this order; each searches only for tags that the previous ones have not
/// found.
enum class TrackerStage : std::uint8_t { follow, enter, nearby, gate, search, audit, conclude };
inline constexpr std::size_t tracker_stages = 7;

/// As a word for people (core/words.h).
constexpr std::string_view word(TrackerStage stage) noexcept {
  switch (stage) {
    case TrackerStage::follow:
      return "follow";
    case TrackerStage::enter:
      return "enter";
    case TrackerStage::nearby:
      return "nearby";
    case TrackerStage::gate:
      return "gate";
    case TrackerStage::search:
      return "search";
    case TrackerStage::audit:
      return "audit";
    case TrackerStage::conclude:
      return "conclude";
  }
  return {};
}

/// How long each stage took [s], in the order of TrackerStage.
using StageTimes = std::array<double, tracker_stages>;

/// What the tracker has done since it was made.
struct TrackerCounters {
  std::int64_t frames = 0;
  std::int64_t full_searches = 0;  // frames searched as a whole
  std::int64_t part_searches = 0;  // and those of which a part was
  std::int64_t poses = 0;          // reported
  std::int64_t ghosts = 0;         // times that a wanted id was seen twice in a frame and therefore not reported
  std::int64_t decoded = 0;        // times that AprilTag has read a wanted tag's id
  std::int64_t rejected = 0;       // wanted tags that were seen and not taken: the sum of the next four
  std::int64_t misshapen = 0;      // not lying flat at tag_height, or not of tag_size
  std::int64_t unlike = 0;         // not like that tag's image: covered, blurred, or none at all
  std::int64_t odd = 0;            // larger than the other tags in the frame
  std::int64_t lifted = 0;         // they looked as usual until they came nearer to the camera
  std::int64_t wrong_frames = 0;   // frames whose size is not the calibration's: nothing is looked for in them
  std::int64_t fits = 0;           // photometric fits that found their tag
  std::int64_t failed_fits = 0;    // and that did not
  std::int64_t looks = 0;          // at the picture, that fits from predicted poses took
  std::int64_t gates = 0;          // frames in which the gate looked over the whole picture
  std::int64_t windows = 0;        // small parts of a frame that AprilTag has searched

  TrackerCounters& operator+=(const TrackerCounters& more) {
    frames += more.frames;
    full_searches += more.full_searches;
    part_searches += more.part_searches;
    poses += more.poses;
    ghosts += more.ghosts;
    decoded += more.decoded;
    rejected += more.rejected;
    misshapen += more.misshapen;
    unlike += more.unlike;
    odd += more.odd;
    lifted += more.lifted;
    wrong_frames += more.wrong_frames;
    fits += more.fits;
    failed_fits += more.failed_fits;
    looks += more.looks;
    gates += more.gates;
    windows += more.windows;
    return *this;
  }
};

}  // namespace skein::vision
