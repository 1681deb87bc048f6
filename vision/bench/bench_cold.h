#pragma once

#include <cstddef>

#include "vision/bench/bench_scenes.h"
#include "vision/bench/bench_score.h"

namespace skein::vision::detail {

/// The scores of the methods on frames that never repeat.
struct ColdScores {
  Scores cold;  // before each timed frame, the benchmark reads more memory than the caches hold
  Scores warm;  // the control: nothing else happens between two frames, and each frame was copied just before
  double jpeg_bytes = 0.0;  // of a frame, on average, where the scene has an MJPEG camera
};

/// AprilTag out of the box, tuned, and the tracker, the first two on a part of the frames; a scene with an MJPEG camera
/// also has "decoding", which the times of all methods include. frames: the number for the tracker, after it has
/// settled.
ColdScores measure_cold(const BenchScene& scene, int frames);

/// The size of this machine's last-level cache, or a likely size where the system does not report one. [bytes]
std::size_t last_level_cache();

}  // namespace skein::vision::detail
