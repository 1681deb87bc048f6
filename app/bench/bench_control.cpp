#include "app/bench/bench_control.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/record/statistics.h"
#include "app/run/interrupted.h"
#include "app/session/session.h"
#include "app/tick/control_tick.h"
#include "core/avoidance/avoidance.h"
#include "core/control/coordination_law.h"
#include "core/simulation/random.h"

namespace skein::app {
namespace {

/// Keeps what a tick is fed with, and what it gives.
class Recording final : public RecordSink {
 public:
  void record(const TickRecord& record) override { records.push_back(record); }
  std::vector<TickRecord> records;
};

std::vector<TickRecord> record_run(const Experiment& experiment) {
  Recording recording;
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&recording}});
  (*session)->run();
  return std::move(recording.records);
}

/// A group of any size with the paper's parameters, fully coupled; the couplings' bounds shrink with the size, as (18f,
/// g) ask. Errors of some centimetres.
struct Group {
  core::Gains gains;
  std::vector<core::TrackingError> errors;
  std::vector<core::Twist> reference, command;

  explicit Group(std::size_t robots)
      : gains(core::paper_gains(robots)), reference(robots, {0.05, 0.2}), command(robots) {
    const double share = 3.0 / static_cast<double>(robots - 1);
    gains.k_xx.fill(0.008 * share);
    gains.k_tt.fill(0.025 * share);
    gains.k_yy.fill(0.08 * share);
    core::use_all_authority(gains, reference);
    core::Random random(1, 0);
    for (std::size_t i = 0; i < robots; ++i)
      errors.push_back({0.05 * random.gaussian(), 0.05 * random.gaussian(), 0.3 * random.gaussian()});
  }
};

/// The law for a group, pair by pair: the baseline.
void law_plain(benchmark::State& state) {
  Group group(static_cast<std::size_t>(state.range(0)));
  for ([[maybe_unused]] auto _ : state) {
    core::coordination_law(group.gains, group.errors, group.reference, group.command);
    benchmark::DoNotOptimize(group.command.data());
    benchmark::ClobberMemory();
  }
}

/// The law as the tick calls it; the counter is its largest difference from the baseline, as a share of the limits.
void law_fast(benchmark::State& state) {
  Group group(static_cast<std::size_t>(state.range(0)));
  core::LawPairs pairs(group.errors.size());
  for ([[maybe_unused]] auto _ : state) {
    core::coordination_law(group.gains, group.errors, group.reference, group.command, pairs);
    benchmark::DoNotOptimize(group.command.data());
    benchmark::ClobberMemory();
  }
  const std::vector<core::Twist> fast = group.command;
  core::coordination_law(group.gains, group.errors, group.reference, group.command);
  double difference = 0.0;
  for (std::size_t i = 0; i < fast.size(); ++i)
    difference = std::max({difference, std::abs(fast[i].v - group.command[i].v) / group.gains.v_max[i],
                           std::abs(fast[i].omega - group.command[i].omega) / group.gains.omega_max[i]});
  state.counters["difference"] = difference;
}

/// A group of any size in rows, 12 cm apart, that drives the same way at the same speed.
struct Rows {
  core::Gains gains;
  std::vector<core::Pose> poses;
  std::vector<core::ReferencePoint> nominal, reference;
  std::vector<core::Twist> command;
  std::vector<double> v_limit;
  std::unique_ptr<bool[]> touched;

  explicit Rows(std::size_t robots)
      : gains(core::paper_gains(robots)),
        reference(robots),
        command(robots, {0.05, 0.0}),
        v_limit(robots, 0.1),
        touched(new bool[robots]()) {
    const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(robots))));
    for (std::size_t i = 0; i < robots; ++i) {
      const std::size_t column = i % side, row = i / side;
      poses.push_back({0.12 * static_cast<double>(column), 0.12 * static_cast<double>(row), 0.3});
      nominal.push_back({poses.back(), command[i]});
    }
  }
};

/// What avoidance and shield looked at when every robot looked at every other: the baseline.
void near_pairs_plain(benchmark::State& state) {
  const Rows rows(static_cast<std::size_t>(state.range(0)));
  const core::AvoidanceParameters region;
  const core::ShieldParameters shield;
  const std::size_t n = rows.poses.size();
  for ([[maybe_unused]] auto _ : state) {
    std::size_t near = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const core::Pose& here = rows.poses[i];
      for (std::size_t j = 0; j < n; ++j)
        near += j != i && core::region_level(region, here.x - rows.poses[j].x, here.y - rows.poses[j].y) <= 1.0;
      for (std::size_t j = i + 1; j < n; ++j)
        near += shield.gamma * (core::distance(here, rows.poses[j]) - shield.distance) < 0.2;
    }
    benchmark::DoNotOptimize(near);
  }
}

/// Avoidance and shield as the tick calls them.
void near_pairs(benchmark::State& state) {
  Rows rows(static_cast<std::size_t>(state.range(0)));
  const std::size_t n = rows.poses.size();
  core::Avoidance avoidance(n, 0);
  core::Shield shield(n, 0);
  const core::Scene scene{rows.poses, rows.command, {rows.touched.get(), n}, {}};
  for ([[maybe_unused]] auto _ : state) {
    avoidance.step({}, rows.gains, 0.04, scene, rows.nominal, rows.reference);
    shield.apply({}, {.poses = rows.poses, .v_limit = rows.v_limit}, rows.command, {rows.touched.get(), n});
    benchmark::DoNotOptimize(rows.command.data());
    benchmark::ClobberMemory();
  }
}

/// The law alone, on the errors of the same run: the baseline of the tick.
void law(benchmark::State& state) {
  const Experiment experiment = paper_experiment();
  const std::vector<TickRecord> run = record_run(experiment);
  const core::Gains gains = make_gains(experiment);
  const std::size_t n = experiment.robots.size();
  std::vector<core::TrackingError> errors(n);
  std::vector<core::Twist> reference(n), command(n);
  std::size_t k = 0;
  for ([[maybe_unused]] auto _ : state) {
    const TickRecord& row = run[k++ % run.size()];
    for (std::size_t i = 0; i < n; ++i) errors[i] = row.robots[i].error, reference[i] = row.robots[i].reference.twist;
    core::coordination_law(gains, errors, reference, command);
    benchmark::DoNotOptimize(command.data());
  }
}

/// The whole tick, on the measurements of a run: estimate, reference, avoidance, law, limits, shield, wheels, record.
void tick(benchmark::State& state) {
  const Experiment experiment = paper_experiment();
  const std::vector<TickRecord> run = record_run(experiment);
  const std::size_t n = experiment.robots.size();
  std::vector<core::Measurement> measurements(n);
  const OperatorCommand start = commands::Start{};
  auto control = std::make_unique<ControlTick>(experiment);
  std::size_t k = 0;
  for ([[maybe_unused]] auto _ : state) {
    if (k == run.size()) {  // the run is over: begin again
      state.PauseTiming();
      control = std::make_unique<ControlTick>(experiment);
      k = 0;
      state.ResumeTiming();
    }
    for (std::size_t i = 0; i < n; ++i) measurements[i] = run[k].robots[i].measurement;
    TickInput input;
    input.now = run[k].now;
    input.measurements = measurements;
    if (k == 0) input.commands = {&start, 1};
    double V = control->step(input).V;
    benchmark::DoNotOptimize(V);
    ++k;
  }
}

/// `skein run platoon.toml --csv`: 2,100 ticks, every column to a file, and the summary.
void whole_run(benchmark::State& state) {
  const Experiment experiment = paper_experiment();
  const auto path = std::filesystem::temp_directory_path() / fmt::format("skein-bench-{}.csv", ::getpid());
  for ([[maybe_unused]] auto _ : state) {
    std::ofstream file(path, std::ios::binary);
    CsvWriter csv(file, experiment);
    Statistics statistics(experiment);
    auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&csv, &statistics}});
    (*session)->run();
    (*session)->close();
    benchmark::DoNotOptimize(statistics.summary().final_error);
  }
  std::filesystem::remove(path);
  state.counters["times_real_time"] =
      benchmark::Counter(experiment.duration * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

/// The same through camera and protocol in real time: rendered frames, AprilTag, asercom over pseudo-terminals.
void loopback(benchmark::State& state) {
  const auto experiment =
      parse_experiment(paper_experiment().source, "platoon.toml",
                       {"robot_defaults.link=loopback", "robot_defaults.model=epuck2", "camera.source=synthetic"});
  for ([[maybe_unused]] auto _ : state) {
    Recording recording;
    Statistics statistics(*experiment);
    auto session = Session::open(*experiment, Session::Clock::wall, {false, {&recording, &statistics}});
    if (!session) {
      state.SkipWithError(session.error().c_str());
      break;
    }
    (*session)->run([] { return !interrupted(); });
    (*session)->close();
    const Statistics::Summary summary = statistics.summary();
    std::vector<double> lateness, age;
    for (std::size_t k = 1; k < recording.records.size(); ++k) {
      const TickRecord& row = recording.records[k];
      lateness.push_back(std::abs(row.period - experiment->period()));
      for (const RobotRecord& robot : row.robots) age.push_back(robot.pose_age);
    }
    const auto percentile = [](std::vector<double>& values, double share) {
      std::sort(values.begin(), values.end());
      return values.empty() ? none
                            : 1e3 * values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
    };
    const auto first = std::count_if(summary.perturbations.begin(), summary.perturbations.end(),
                                     [](const PerturbationResult& p) { return p.formation_first(); });
    state.counters["ticks"] = static_cast<double>(summary.ticks);
    state.counters["missed_deadlines"] = static_cast<double>(summary.missed_deadlines);
    state.counters["period_error_ms_p99"] = percentile(lateness, 0.99);
    state.counters["pose_age_ms_p50"] = percentile(age, 0.5);
    state.counters["pose_age_ms_p99"] = percentile(age, 0.99);
    state.counters["formation_first"] = static_cast<double>(first);
    state.counters["perturbations"] = static_cast<double>(summary.perturbations.size());
    state.counters["final_error_mm"] = 1e3 * summary.final_error;
  }
}

}  // namespace

void register_tick_benchmarks() {
  // One tick and its baseline, interleaved; the median of nine repetitions stands for each.
  const auto often = [](auto* b) { b->Repetitions(9)->ReportAggregatesOnly(true)->Unit(benchmark::kMicrosecond); };
  often(benchmark::RegisterBenchmark("law (n = 4, baseline)", law));
  often(benchmark::RegisterBenchmark("tick (n = 4)", tick));
}

void register_control_benchmarks() {
  const auto sizes = [](auto* b) { b->Arg(4)->Arg(100)->Arg(1000)->Unit(benchmark::kMicrosecond); };
  sizes(benchmark::RegisterBenchmark("law, pair by pair (baseline)", law_plain));
  sizes(benchmark::RegisterBenchmark("law", law_fast));
  sizes(benchmark::RegisterBenchmark("avoidance + shield, all pairs (baseline)", near_pairs_plain));
  sizes(benchmark::RegisterBenchmark("avoidance + shield", near_pairs));
}

void register_run_benchmark() {
  benchmark::RegisterBenchmark("run platoon.toml --csv", whole_run)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime()
      ->MinTime(2.0);
}

void register_loopback_benchmark() {
  benchmark::RegisterBenchmark("loopback in real time", loopback)
      ->Unit(benchmark::kSecond)
      ->UseRealTime()
      ->Iterations(1);
}

}  // namespace skein::app
