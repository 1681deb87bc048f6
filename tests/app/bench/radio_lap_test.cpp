// The paper's lap over a slow radio, in virtual time.
#include "app/bench/radio_lap.h"

#include <gtest/gtest.h>

#include "app/experiment/experiment_file.h"

namespace skein::app {
namespace {

Experiment lap_with(const std::vector<std::string>& sets) {
  std::vector<std::string> all{"robot_defaults.model=epuck2"};
  all.insert(all.end(), sets.begin(), sets.end());
  return parse_experiment(paper_experiment().source, "platoon.toml", all).value();
}

TEST(RadioLap, ARadioOf60MillisecondsRunsThePapersLap) {
  const RadioLap lap = radio_lap(lap_with({}), {});
  EXPECT_FALSE(lap.all_stop) << lap.why;
  EXPECT_NEAR(lap.rtt_median, 0.06, 0.02);
  EXPECT_GT(lap.rtt_p999, 0.15);
  EXPECT_EQ(lap.perturbations, 3u);
  EXPECT_EQ(lap.recovered, 3u);
  EXPECT_GT(lap.written, 0.99) << "speeds go out in every tick";
  EXPECT_EQ(lap.wrong_speeds, 0u);
  EXPECT_LE(lap.blind_way, LinksSpec{}.blind_distance);
}

/// The control: with the patience of a link to a pseudo-terminal the same radio is a lost robot.
TEST(RadioLap, ThePatienceOfABareSocketStopsTheGroupOverTheSameRadio) {
  const RadioLap lap = radio_lap(lap_with({"links.reply_timeout=0.08", "failure.link_bridge=0.1"}), {});
  EXPECT_TRUE(lap.all_stop);
}

TEST(RadioLap, NoRandomFaultsLetARobotDriveMoreThanItsBlindDistance) {
  Experiment experiment = lap_with({"failure.link_lost=others_go_on"});
  experiment.duration = 6.0;
  experiment.reference.speed = 0.09;
  experiment.perturbations.clear();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RadioLapOptions options;
    options.seed = seed;
    options.faults = comms::random_faults(experiment.robots.size(), 11.0, 4.0, seed);
    EXPECT_LE(radio_lap(experiment, options).blind_way, experiment.links.blind_distance) << seed;
  }
}

}  // namespace
}  // namespace skein::app
