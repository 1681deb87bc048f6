#pragma once

namespace skein::vision {

/// Registers with Google Benchmark: the tracker, AprilTag as it comes and tuned, and OpenCV's ArUco, on the same
/// synthetic frames. A benchmark's time is the median of a frame; its counters are p99 and the worst, how many times
/// faster than tuned AprilTag (medians, p99s) and than AprilTag as it comes, position and heading rms, the tracker's
/// squared errors in units of its covariance per degree of freedom (NEES), recall of the tags in sight, and wrong poses
/// and ids. cold_frames: of each scene that is measured with cold caches, too; 0: none of these.
void register_vision_benchmarks(int cold_frames);

/// After they have run: what the tracker had to reach in the scenes that were measured, one line each. false: it has
/// missed something.
bool print_vision_targets();

}  // namespace skein::vision
