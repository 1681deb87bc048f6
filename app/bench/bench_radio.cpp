#include "app/bench/bench_radio.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "app/bench/radio_lap.h"
#include "app/experiment/experiment_file.h"
#include "app/run/interrupted.h"

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
  for (auto _ : state) {
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

/// Ten seconds each at 0.1 m/s, over the same radio, with faults of every kind at random.
void faults(benchmark::State& state) {
  Experiment experiment = platoon(4);
  experiment.duration = 10.0;
  experiment.perturbations.clear();
  experiment.reference.speed = 0.09;
  experiment.failure.link_lost = FailureSpec::LinkLost::others_go_on;
  for (auto _ : state) {
    double worst = 0.0;
    int over = 0, run = 0;
    for (; run < state.range(0) && !interrupted(); ++run) {
      const auto seed = static_cast<std::uint64_t>(run + 1);
      RadioLapOptions options;
      options.seed = seed;
      options.faults = comms::random_faults(experiment.robots.size(), 15.0, 5.0, seed);
      const RadioLap lap = radio_lap(experiment, options);
      worst = std::max(worst, lap.blind_way);
      if (lap.blind_way > experiment.links.blind_distance) ++over;
    }
    state.counters["sequences"] = run;
    state.counters["over_blind_distance"] = over;
    state.counters["blind_distance_mm"] = 1e3 * experiment.links.blind_distance;
    state.counters["worst_blind_way_mm"] = 1e3 * worst;
  }
}

}  // namespace

void register_radio_benchmarks() {
  for (const int robots : {4, 28})
    benchmark::RegisterBenchmark("radio: the paper's lap", lap)->Arg(robots)->Unit(benchmark::kSecond)->Iterations(1);
  benchmark::RegisterBenchmark("radio: random faults", faults)->Arg(1000)->Unit(benchmark::kSecond)->Iterations(1);
}

}  // namespace skein::app
