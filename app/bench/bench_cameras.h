#pragma once

#include <cstdint>

namespace skein::app {

struct CamerasBench {
  std::int64_t runs = 10'000;  ///< crossings of a seam
  std::uint64_t seed = 1;
};

/// Several cameras over one floor: the time from four frames to all poses, and robots that cross the seam of two
/// cameras whose calibrations differ, compared with methods without fusion. Returns an ExitStatus: expectation_failed
/// where a goal is missed.
int bench_cameras(const CamerasBench& bench);

}  // namespace skein::app
