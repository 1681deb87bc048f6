// The paper's lap over a slow radio, in virtual time.
#include "app/bench/radio_lap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

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

// A parser that was left within a speed command took the next request for full speed, and the host knew nothing of it:
// 51 to 75 mm in these sequences of `skein-bench radio`.
TEST(RadioLap, GarbledSpeedsLetNobodyDriveMoreThanItsBlindDistance) {
  Experiment experiment = lap_with({"failure.link_lost=others_go_on"});
  experiment.duration = 10.0;
  experiment.reference.speed = 0.09;
  experiment.perturbations.clear();
  for (const std::uint64_t seed : {233u, 456u, 556u, 575u, 849u, 942u, 964u, 967u, 983u}) {
    RadioLapOptions options;
    options.seed = seed;
    options.faults = comms::random_faults(experiment.robots.size(), 15.0, 5.0, seed);
    EXPECT_LE(radio_lap(experiment, options).blind_way, experiment.links.blind_distance) << seed;
  }
}

// A robot that had restarted was catching up at 0.14 m/s when interference carried nothing for 0.4 s: 66 mm, and no
// host could have stopped it.
TEST(RadioLap, WhoeverCatchesUpDrivesNoMoreThanItsBlindDistanceWhileTheRadioCarriesNothing) {
  Experiment experiment = lap_with({"failure.link_lost=others_go_on"});
  experiment.duration = 10.0;
  experiment.reference.speed = 0.09;
  experiment.perturbations.clear();
  RadioLapOptions options;
  options.seed = 247;
  options.faults = comms::random_faults(experiment.robots.size(), 15.0, 5.0, options.seed);
  EXPECT_LE(radio_lap(experiment, options).blind_way, experiment.links.blind_distance);
}

/// The control: without the blind distance the same sequences let robots drive farther.
TEST(RadioLap, WithoutItsBlindDistanceTheSameFaultsLetARobotDriveFarther) {
  Experiment experiment = lap_with({"failure.link_lost=others_go_on"});
  experiment.duration = 6.0;
  experiment.reference.speed = 0.09;
  experiment.perturbations.clear();
  experiment.links.blind_distance = 1e3;
  double worst = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    RadioLapOptions options;
    options.seed = seed;
    options.faults = comms::random_faults(experiment.robots.size(), 11.0, 4.0, seed);
    worst = std::max(worst, radio_lap(experiment, options).blind_way);
  }
  EXPECT_GT(worst, LinksSpec{}.blind_distance);
}

double steady_x_e(core::MotorModel motors, core::MotorModel taken_for) {
  Experiment experiment = lap_with({"robot_defaults.model=" + std::string(word(taken_for))});
  experiment.perturbations.clear();
  RadioLapOptions options;
  options.radio = quick_radio();
  options.motors = motors;
  return radio_lap(experiment, options).steady_x_e;
}

/// The control: the same motors where nobody reckons with what a speed command costs them.
TEST(RadioLap, SteadyErrorsAreSmallerWhereMotorsAreTakenForWhatTheyAre) {
  using enum core::MotorModel;
  EXPECT_LT(steady_x_e(epuck2, epuck2), 0.05e-3);
  EXPECT_GT(steady_x_e(epuck2, ideal), 0.1e-3);
  EXPECT_LT(steady_x_e(epuck1, epuck1), 0.2e-3) << "the speed of one wheel costs the other one steps as well";
  EXPECT_GT(steady_x_e(epuck1, ideal), steady_x_e(epuck1, epuck1));
}

}  // namespace
}  // namespace skein::app
