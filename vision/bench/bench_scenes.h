#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::vision::detail {

/// The contents of one frame, and the tags that a tracker must find.
struct BenchMoment {
  std::vector<SyntheticTag> tags;
  std::vector<SyntheticDisc> discs;
  std::vector<bool> in_sight;  // of each tag: nothing of it or its white border is hidden
};

/// The tracker's targets in a scene; NaN: no target. Every scene also requires that no pose and no id is wrong.
struct BenchTargets {
  static constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
  double median_ms = nothing;
  double p99_ms = nothing;
  double times_faster = nothing;  // than AprilTag out of the box
  double xy_mm = nothing;         // rms
  double deg = nothing;           // rms
  double recall = nothing;        // of the tags in sight [%]; never below that of AprilTag out of the box
};

/// The tracker's targets with cold caches, on frames that never repeat. AprilTag: tuned, also with cold caches.
struct ColdTargets {
  double times_faster = BenchTargets::nothing;      // than AprilTag, of the medians
  double times_faster_p99 = BenchTargets::nothing;  // of the slowest hundredth
  double p99_ms = BenchTargets::nothing;
};

struct BenchScene {
  std::string name;
  Calibration calibration;
  SceneOptions options;
  int tags = 16;
  bool first_only = false;  // every frame is the first of a new tracker
  int rounds = 8;           // of 125 frames each
  bool periodic = true;     // every round is the same film
  /// Frame k of a 25 Hz film; called in order.
  std::function<BenchMoment(int k)> moment;
  BenchTargets targets{};
  ColdTargets cold{};
  bool mjpeg = false;  // frames come as an MJPEG camera's, and are decoded first
};

inline constexpr int bench_frames = 125;      // of a round: 5 s
inline constexpr double bench_period = 0.04;  // between frames [s]

/// The table of docs/vision.md.
std::vector<BenchScene> bench_scenes();

/// Scenes as in use: no frame repeats, because no robot returns to its place to within a fraction of a pixel. For
/// measurements with cold caches.
std::vector<BenchScene> cold_scenes();

}  // namespace skein::vision::detail
