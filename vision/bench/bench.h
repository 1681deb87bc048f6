#pragma once

namespace skein::vision {

/// Registers with Google Benchmark: the tracker, AprilTag out of the box and tuned, and OpenCV's ArUco, on the same
/// synthetic frames. A benchmark's time is the median of a frame; its counters are p99 and the worst, how many times
/// faster than tuned AprilTag (medians, p99s) and than AprilTag out of the box, position and heading rms, the tracker's
/// squared errors in units of its covariance per degree of freedom (NEES), recall of the tags in sight, and wrong poses
/// and ids. cold_frames: the number of frames of each scene that is also measured with cold caches; 0: no such
/// measurement.
void register_vision_benchmarks(int cold_frames);

/// After the benchmarks: prints the tracker's targets in the measured scenes, one line each. false: the tracker missed
/// a target.
bool print_vision_targets();

}  // namespace skein::vision
