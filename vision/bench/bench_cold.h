#pragma once

#include <cstddef>

#include "vision/bench/bench_scenes.h"
#include "vision/bench/bench_score.h"

namespace skein::vision::detail {

/// How methods do on frames that never repeat.
struct ColdScores {
  Scores cold;              // before each timed frame, more memory is walked through than the caches hold
  Scores warm;              // the control: nothing else is done between two frames, and a frame was copied just before
  double jpeg_bytes = 0.0;  // of a frame, on average, where the scene has an MJPEG camera
};

/// AprilTag as it comes, tuned, and the tracker, the first two on a part of the frames; a scene with an MJPEG camera
/// has "decoding", too, which is in the times of all. frames: of the tracker, after it has settled.
ColdScores measure_cold(const BenchScene& scene, int frames);

/// Of this machine's last-level cache, or what is likely where it does not say. [bytes]
std::size_t last_level_cache();

}  // namespace skein::vision::detail
