#include "app/bench/bench_radio.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "app/bench/radio_lap.h"
#include "app/experiment/experiment_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"

namespace skein::app {
namespace {

/// The paper's platoon with any number of robots. More than four need a longer path for the same spacing, and couplings
/// that share what (18) leaves.
Experiment platoon(std::size_t robots) {
  std::vector<std::string> sets{"robot_defaults.model=epuck2"};
  if (robots == 4) return parse_experiment(paper_experiment().source, "platoon.toml", sets).value();
  std::string source = paper_experiment().source;
  source.erase(std::min(source.find("[[robot]]"), source.size()));
  for (std::size_t i = 1; i <= robots; ++i) source += fmt::format("[[robot]]\ntag = {}\n", i);
  source +=
      "[[perturb]]\nt = 10\nrobot = 2\ndx = 0.0\ndy = 0.15\n"
      "[[perturb]]\nt = 30\nrobot = 9\ndx = 0.0\ndy = 0.15\n";
  const double share = 3.0 / static_cast<double>(robots - 1);
  for (const auto& [key, value] : {std::pair{"k_xx", 0.008}, {"k_tt", 0.025}, {"k_yy", 0.08}})
    sets.push_back(fmt::format("controller.gains.{}={:g}", key, value * share));
  for (const char* const set : {"arena.width=4.2", "arena.height=3.2", "reference.path.width=3.4",
                                "reference.path.height=2.4", "avoidance.enabled=false"})
    sets.emplace_back(set);
  return parse_experiment(source, "platoon.toml", sets).value();
}

void lap(benchmark::State& state) {
  const auto robots = static_cast<std::size_t>(state.range(0));
  const Experiment experiment = platoon(robots);
  for ([[maybe_unused]] auto _ : state) {
    const RadioLap run = radio_lap(experiment, {});
    state.counters["rtt_ms_median"] = 1e3 * run.rtt_median;
    state.counters["rtt_ms_p99"] = 1e3 * run.rtt_p99;
    state.counters["rtt_ms_p999"] = 1e3 * run.rtt_p999;
    state.counters["all_stop"] = run.all_stop ? 1 : 0;
    state.counters["perturbations"] = static_cast<double>(run.perturbations);
    state.counters["recovered"] = static_cast<double>(run.recovered);
    state.counters["final_error_mm"] = 1e3 * run.final_error;
    state.counters["min_distance_mm"] = 1e3 * run.min_distance;
    state.counters["written_in_their_tick"] = run.written;
    state.counters["late_ticks"] = run.late_ticks;
    state.counters["blind_stops"] = static_cast<double>(run.blind_stops);
    state.counters["timeouts"] = static_cast<double>(run.timeouts);
    state.counters["blind_way_mm"] = 1e3 * run.blind_way;
    if (run.all_stop) state.SetLabel(run.why);
  }
}

/// Ten seconds at 0.09 m/s; a lost robot stops no other robot.
Experiment faulty_run() {
  Experiment experiment = platoon(4);
  experiment.duration = 10.0;
  experiment.perturbations.clear();
  experiment.reference.speed = 0.09;
  experiment.failure.link_lost = FailureSpec::LinkLost::others_go_on;
  return experiment;
}

struct FaultStudy {
  int runs = 0, over = 0;                   // beyond the blind distance
  double worst = 0.0, worst_held_up = 0.0;  // [m]
  std::uint64_t worst_seed = 0;
};

FaultStudy study_faults(const Experiment& experiment, const RadioBench& bench) {
  FaultStudy study;
  for (; study.runs < bench.faults && !interrupted(); ++study.runs) {
    RadioLapOptions options;
    options.seed = bench.seed + static_cast<std::uint64_t>(study.runs);
    options.faults = comms::random_faults(experiment.robots.size(), 15.0, 5.0, options.seed);
    const RadioLap lap = radio_lap(experiment, options);
    if (lap.blind_way > LinksSpec{}.blind_distance) ++study.over;
    study.worst_held_up = std::max(study.worst_held_up, lap.held_up_way);
    if (lap.blind_way <= study.worst) continue;
    study.worst = lap.blind_way;
    study.worst_seed = options.seed;
  }
  return study;
}

}  // namespace

void register_radio_benchmarks() {
  for (const int robots : {4, 28})
    benchmark::RegisterBenchmark("radio: the paper's lap", lap)->Arg(robots)->Unit(benchmark::kSecond)->Iterations(1);
}

int report_radio_faults(const RadioBench& bench) {
  if (bench.faults == 0) return done;
  constexpr double no_limit = 1e3;  // [m]
  const Experiment as_it_is = faulty_run();
  // What is left without it: an answer that does not come within links.reply_timeout, then a link that is lost.
  Experiment time_out = as_it_is;
  time_out.links.blind_distance = no_limit;
  Experiment silence = time_out;
  silence.links.reply_timeout = silence.failure.link_bridge;

  print_out(
      fmt::format("random faults: {} sequences from seed {} on, 4 robots, 10 s at 0.09 m/s each; links.blind_distance "
                  "{:.0f} mm\n{:<48} {:>9} {:>6} {:>10} {:>18}\n",
                  bench.faults, bench.seed, 1e3 * LinksSpec{}.blind_distance, "", "worst mm", "seed", "beyond it",
                  "held up by a fault"));
  int status = done;
  for (const auto& [name, experiment] : {std::pair{"as it is", &as_it_is},
                                         {"without blind distance: a missing answer alone", &time_out},
                                         {"without either: a lost link and silence alone", &silence}}) {
    const FaultStudy study = study_faults(*experiment, bench);
    print_out(fmt::format("{:<48} {:9.1f} {:6} {:5}/{} {:15.1f} mm\n", name, 1e3 * study.worst, study.worst_seed,
                          study.over, study.runs, 1e3 * study.worst_held_up));
    if (experiment == &as_it_is && study.over > 0) status = expectation_failed;
  }
  return status;
}

}  // namespace skein::app
