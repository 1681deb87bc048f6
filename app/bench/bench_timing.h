#pragma once

#include <cstdint>
#include <span>

#include "app/run/timing.h"

namespace skein::app {

/// A quantile of the lateness of ticks over that of the bare thread, each over all runs together, with its 95 %
/// interval: bootstrap of whole runs, since the load of a machine makes what is near in time alike.
struct TimingRatio {
  double ratio, low, high;
};
/// `runs`: at least one, each with ticks and a bare thread that were late. The same seed gives the same interval.
TimingRatio timing_ratio(std::span<const Timing> runs, double share, std::uint64_t seed);
/// The same of the geometric mean of the runs' own ratios.
TimingRatio mean_timing_ratio(std::span<const Timing> runs, double share, std::uint64_t seed);

struct TimingBench {
  std::int64_t runs = 20;
  double seconds = 60.0;  ///< of each run
  std::uint64_t seed = 1;
};

/// The timing certificate over many runs of `platoon-loopback.toml` in real time: the lateness of the ticks beside that
/// of the bare thread, run by run, then the ratios with their intervals. On stdout. Returns an ExitStatus:
/// expectation_failed if the interval of the p99.9 of all runs together reaches more than 1.5.
int bench_timing(const TimingBench& request);

}  // namespace skein::app
