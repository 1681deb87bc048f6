// How late a camera's stamps are, from a turn on the spot: found to a millisecond, with an honest standard deviation.
#include "core/estimation/latency_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "wandering_stamps.h"

namespace skein::test {
namespace {

using core::LatencyFit;
using core::TurnRecord;

TEST(LatencyFit, FindsDelayAndScale) {
  TurnRecord turn = turn_with_wandering_stamps(0.0);
  const LatencyFit found = core::fit_latency(turn);
  EXPECT_NEAR(found.late, 0.02, 1e-3);
  EXPECT_LT(found.sigma, 5e-4);
  EXPECT_NEAR(found.scale, 1.0, 1e-3);
  EXPECT_LT(found.heading_rms, 2e-3) << "counters in whole steps, of 4.9 mrad, are off by 1.4 mrad rms, poses by 0.7";
  EXPECT_NEAR(found.halves[0], found.halves[1], 1e-3);

  turn.believed.track *= 0.8;
  const LatencyFit wrong_wheels = core::fit_latency(turn);
  EXPECT_NEAR(wrong_wheels.late, 0.02, 1e-3);
  EXPECT_NEAR(wrong_wheels.scale, 0.8, 1e-3);
}

TEST(LatencyFit, ShowsWhereStampsWander) {
  const LatencyFit little = core::fit_latency(turn_with_wandering_stamps(0.0023));
  EXPECT_NEAR(little.halves[1] - little.halves[0], 0.0023, 3e-4);
  const LatencyFit much = core::fit_latency(turn_with_wandering_stamps(0.01));
  EXPECT_GT(much.sigma, 5e-4);
}

/// 1.2 rad to and 1.2 rad fro, 11.5 times in 12 s.
TEST(TurnRecord, CountsTurnsInEitherDirection) {
  const TurnRecord turn = turn_with_wandering_stamps(0.0);
  EXPECT_NEAR(turn.turned(), 2.4 * 11.5, 0.5);
  EXPECT_EQ(TurnRecord{}.turned(), 0.0);
}

TEST(LatencyFit, KnowsNothingFromTooLittle) {
  TurnRecord few = turn_with_wandering_stamps(0.0);
  few.poses.resize(LatencyFit::least_poses - 1);
  EXPECT_TRUE(std::isnan(core::fit_latency(few).late));
  TurnRecord uncounted = turn_with_wandering_stamps(0.0);
  uncounted.wheels.clear();
  EXPECT_TRUE(std::isnan(core::fit_latency(uncounted).late));
  EXPECT_EQ(uncounted.turned(), 0.0);
}

}  // namespace
}  // namespace skein::test
