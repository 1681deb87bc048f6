// The methods that planned routes are compared with: they do what their papers say, or the comparison would be none.
#include "app/bench/swap_baselines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/kinematics/unicycle.h"

namespace skein::app {
namespace {

using core::Pose;
using core::Twist;

TEST(NhOrca, ATurnEndsAsFarFromTheStraightLineAsItSays) {
  const core::CommandLimits limits;
  for (double angle = -3.0; angle <= 3.0; angle += 0.37)
    for (const double speed : {0.01, 0.05, 0.1}) {
      // As in the paper: E = V t sin(theta / 2) where the arc is not limited by the wheels.
      const double said = nh_orca_error(limits, angle, speed);
      const double lasts = std::max(0.35, std::abs(angle) / limits.omega_limit());
      EXPECT_GE(said, speed * lasts * std::abs(std::sin(0.5 * angle)) - 1e-9) << angle << ' ' << speed;
      if (speed < 0.04) {
        EXPECT_NEAR(said, speed * lasts * std::abs(std::sin(0.5 * angle)), 1e-9) << angle << ' ' << speed;
      }
    }
  EXPECT_NEAR(nh_orca_error(limits, 0.0, 0.1), 0.0, 1e-9);
}

struct Swapped {
  double least = 1e9, last = 0.0, outside = -1.0;
};

Swapped swap(SwapMethod& method, std::vector<Pose> poses, const std::vector<Pose>& places) {
  const core::CommandLimits limits;
  std::vector<Twist> commands(poses.size());
  Swapped swapped;
  for (int k = 0; k < 1500; ++k) {
    method.step(poses, places, 0.04, commands);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_LE(std::abs(commands[i].v), 0.1 + 1e-9);
      EXPECT_LE(std::abs(commands[i].omega), 1.7 + 1e-9);
      poses[i] = core::advance(poses[i], limits.limit(commands[i]), 0.04);
      swapped.outside =
          std::max({swapped.outside, std::abs(poses[i].x) + 0.035 - 1.0, std::abs(poses[i].y) + 0.035 - 0.75});
      for (std::size_t j = 0; j < i; ++j) swapped.least = std::min(swapped.least, core::distance(poses[i], poses[j]));
    }
  }
  for (std::size_t i = 0; i < poses.size(); ++i)
    swapped.last = std::max(swapped.last, core::distance(poses[i], places[i]));
  return swapped;
}

class SwapBaselines
    : public testing::TestWithParam<std::unique_ptr<SwapMethod> (*)(const core::CommandLimits&, HalfArena)> {};

TEST_P(SwapBaselines, SwapFourRobotsWithoutATouch) {
  const std::vector<Pose> starts{{-0.5, 0.02, 0.0}, {0.5, 0.0, 0.5}, {0.03, 0.5, -2.0}, {0.0, -0.5, 1.0}};
  const std::vector<Pose> places{{0.5, 0.0, 0.0}, {-0.5, 0.0, 0.0}, {0.0, -0.5, 0.0}, {0.0, 0.5, 0.0}};
  const auto method = GetParam()({}, {});
  const Swapped swapped = swap(*method, starts, places);
  EXPECT_GT(swapped.least, 0.07);
  EXPECT_LT(swapped.last, 0.01);
}

TEST_P(SwapBaselines, GoRoundOneThatStandsInTheWay) {
  const auto method = GetParam()({}, {});
  const Swapped swapped = swap(*method, {{-0.4, 0.005, 0.0}, {0.0, 0.0, 1.0}}, {{0.4, 0.0, 0.0}, {0.0, 0.0, 1.0}});
  EXPECT_GT(swapped.least, 0.07);
  EXPECT_LT(swapped.last, 0.01);
}

TEST_P(SwapBaselines, StayInsideTheArena) {
  const auto method = GetParam()({}, {});
  const Swapped swapped = swap(*method, {{0.9, 0.6, 0.7}}, {{1.2, 1.0, 0.0}});
  EXPECT_LE(swapped.outside, 0.0);
}

INSTANTIATE_TEST_SUITE_P(Both, SwapBaselines, testing::Values(make_nh_orca, make_barrier_certificates));

}  // namespace
}  // namespace skein::app
