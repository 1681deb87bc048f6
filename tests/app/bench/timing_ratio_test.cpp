// The ratio of late ticks to a late bare thread, over several runs.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "app/bench/bench_timing.h"
#include "core/simulation/random.h"

namespace skein::app {
namespace {

/// Runs on a machine whose load differs from run to run, and is the same for both.
std::vector<Timing> runs_of(int count, double factor) {
  core::Random random(1, 0);
  std::vector<Timing> runs(static_cast<std::size_t>(count));
  for (Timing& run : runs) {
    const double load = std::exp(random.gaussian());
    for (int tick = 0; tick < 1500; ++tick) {
      run.tick.add(factor * load * 1e-4 * std::exp(random.gaussian()));
      run.bare.add(load * 1e-4 * std::exp(random.gaussian()));
    }
  }
  return runs;
}

TEST(TimingRatio, ItsIntervalHoldsTheTruthAndTellsRatiosApart) {
  for (const double share : {0.5, 0.99, 0.999})
    for (const double factor : {1.0, 3.0}) {
      const std::vector<Timing> runs = runs_of(30, factor);
      const TimingRatio found = timing_ratio(runs, share, 1);
      EXPECT_LE(found.low, factor);
      EXPECT_GE(found.high, factor);
      EXPECT_LE(found.low, found.ratio);
      EXPECT_GE(found.high, found.ratio);
      EXPECT_GT(found.low / factor, 0.5);
      EXPECT_LT(found.high / factor, 2.0);
      const TimingRatio mean = mean_timing_ratio(runs, share, 1);
      EXPECT_LE(mean.low, factor);
      EXPECT_GE(mean.high, factor);
      EXPECT_LT(mean.high / mean.low, 2.0);
    }
}

TEST(TimingRatio, TheSameSeedGivesTheSameInterval) {
  const std::vector<Timing> runs = runs_of(5, 1.0);
  EXPECT_EQ(timing_ratio(runs, 0.99, 7).high, timing_ratio(runs, 0.99, 7).high);
}

}  // namespace
}  // namespace skein::app
