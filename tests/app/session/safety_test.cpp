// What keeps robots apart, as a whole run sees it: it costs nothing where nobody is near, and the experiments that come
// with Skein hold what they promise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <filesystem>

#include "app/experiment/experiment_file.h"
#include "app/record/statistics.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/fixture.h"

namespace skein::app {
namespace {

TEST(Safety, CostsTheUndisturbedPlatoonNotABit) {
  const std::string text = paper_experiment().source;
  const Sets off{"perturb=[]", "avoidance.enabled=false", "shield.enabled=false"};
  const std::vector<TickRecord> with = test::simulate(good(text, {"perturb=[]"})),
                                without = test::simulate(good(text, off));
  ASSERT_EQ(with.size(), without.size());
  for (std::size_t k = 0; k < with.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i) {
      const RobotRecord &a = with[k].robots[i], &b = without[k].robots[i];
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a.command.v), std::bit_cast<std::uint64_t>(b.command.v)) << k;
      ASSERT_EQ(std::bit_cast<std::uint64_t>(a.command.omega), std::bit_cast<std::uint64_t>(b.command.omega)) << k;
      ASSERT_EQ(a.wheels.left, b.wheels.left) << k;
      ASSERT_EQ(a.wheels.right, b.wheels.right) << k;
    }
}

TEST(Safety, NoiseAndDelayWidenTheShield) {
  // Two robots nose to nose: how near do they come?
  const auto nearest = [](Sets sets) {
    sets.insert(sets.end(), {"duration=8", "robot_defaults.model=epuck2"});
    const std::string two =
        "[reference]\nkind = \"independent\"\nmay_meet = true\nspeed = 0.09\n[avoidance]\nenabled = false\n"
        "[controller.gains]\nk_xx = 0\nk_tt = 0\nk_yy = 0\n"
        "[[robot]]\ntrajectory = { path = { shape = \"line\", from = [-0.3, 0.0], to = [0.3, 0.0] } }\n"
        "[[robot]]\ntrajectory = { path = { shape = \"line\", from = [0.3, 0.0], to = [-0.3, 0.0] } }\n";
    double least = 1.0;
    for (const TickRecord& row : test::simulate(good(two, sets))) least = std::min(least, row.min_distance);
    return least;
  };
  EXPECT_NEAR(nearest({}), 0.078, 1e-4) << "exact poses that are not old: the shield's distance and no more";
  EXPECT_GT(nearest({"simulation.pose_noise=0.002"}), 0.078) << "three deviations of each, filtered";
  EXPECT_GT(nearest({"simulation.latency=0.16"}), 0.0775) << "what a pose is late by is made up for";
}

/// An experiment that comes with Skein, on simulated robots alone.
class Shipped : public ::testing::TestWithParam<const char*> {};

TEST_P(Shipped, HoldsWhatItExpects) {
  const auto e = load_experiment(experiments + GetParam());
  ASSERT_TRUE(e) << e.error().front().message();
  Statistics statistics(*e);
  auto session = Session::open(*e, Session::Clock::virtual_, {false, {&statistics}});
  ASSERT_TRUE(session) << session.error();
  EXPECT_EQ((*session)->run(), Phase::finished);
  EXPECT_EQ(e->expect.collisions, 0);
  EXPECT_THAT(failed_expectations(e->expect, statistics.summary()), ::testing::IsEmpty());
}
INSTANTIATE_TEST_SUITE_P(Experiments, Shipped,
                         ::testing::Values("obstacles.toml", "crossing.toml", "kidnap.toml", "antipodal-swap-4.toml",
                                           "antipodal-swap-6.toml", "antipodal-swap-10.toml",
                                           "antipodal-swap-20.toml"));

}  // namespace
}  // namespace skein::app
