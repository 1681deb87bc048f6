#include "app/bench/bench_motors.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "app/bench/radio_lap.h"
#include "app/experiment/experiment_file.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"

namespace skein::app {
namespace {

/// The last 20 s of the paper's lap. `taken_for`: what the tick takes the motors for.
RadioLap steady_lap(core::MotorModel motors, core::MotorModel taken_for) {
  const std::vector<std::string> sets{fmt::format("robot_defaults.model={}", word(taken_for))};
  Experiment experiment = parse_experiment(paper_experiment().source, "platoon.toml", sets).value();
  experiment.perturbations.clear();
  RadioLapOptions options;
  options.radio = quick_radio();
  options.motors = motors;
  return radio_lap(experiment, options);
}

}  // namespace

int bench_motors() {
  constexpr double goal = 0.5e-3;  // [m]
  print_out(
      fmt::format("|x_e| of the worst of four emulated robots at 0.05 m/s, last 20 s of the paper's lap [mm]\n"
                  "{:<8} {:>24} {:>6} {:>9}\n",
                  "", "", "rms", "largest"));
  int status = done;
  for (const core::MotorModel motors : {core::MotorModel::epuck1, core::MotorModel::epuck2})
    for (const bool modelled : {true, false}) {
      const RadioLap lap = steady_lap(motors, modelled ? motors : core::MotorModel::ideal);
      print_out(fmt::format("{:<8} {:>24} {:>6.2f} {:>9.2f}\n", word(motors),
                            modelled ? "as they are" : "taken for even motors", 1e3 * lap.steady_x_e,
                            1e3 * lap.largest_x_e));
      if (modelled && motors == core::MotorModel::epuck1 && lap.steady_x_e > goal) status = expectation_failed;
    }
  return status;
}

}  // namespace skein::app
