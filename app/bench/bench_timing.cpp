#include "app/bench/bench_timing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/session/session.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

double ratio_of(const Histogram& tick, const Histogram& bare, double share) {
  return tick.quantile(share) / bare.quantile(share);
}

/// A statistic of all runs, and its interval from runs that are drawn again. `of`: of a function that names the k-th.
template <typename Of>
TimingRatio bootstrap(std::size_t runs, std::uint64_t seed, Of&& of) {
  constexpr std::size_t resamples = 2000;
  constexpr double tail = 0.025, last = resamples - 1;
  std::mt19937_64 random(seed);
  std::vector<double> drawn(resamples);
  for (double& one : drawn) one = of([&](std::size_t) { return random() % runs; });
  std::sort(drawn.begin(), drawn.end());
  return {of([](std::size_t k) { return k; }), drawn[static_cast<std::size_t>(std::floor(tail * last))],
          drawn[static_cast<std::size_t>(std::ceil((1.0 - tail) * last))]};
}

tl::expected<Timing, std::string> run_in_real_time(const Experiment& experiment) {
  auto session = Session::open(experiment, Session::Clock::wall);
  if (!session) return tl::unexpected(session.error());
  (*session)->run([] { return !interrupted(); });
  (*session)->close();
  if (const auto failure = (*session)->failure()) return tl::unexpected(*failure);
  return *(*session)->timing();
}

std::string line_of(const Timing& timing) {
  std::string line;
  for (const double share : {0.5, 0.99, 0.999}) {
    const double tick = timing.tick.quantile(share), bare = timing.bare.quantile(share);
    line += fmt::format("{:>12.0f} {:>8.0f} {:>6.2f}", 1e6 * tick, 1e6 * bare, tick / bare);
  }
  return line + '\n';
}

}  // namespace

TimingRatio timing_ratio(std::span<const Timing> runs, double share, std::uint64_t seed) {
  return bootstrap(runs.size(), seed, [&](auto&& run_of) {
    Histogram tick, bare;
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const Timing& run = runs[run_of(k)];  // drawn once: tick and bare thread of the same run
      tick += run.tick, bare += run.bare;
    }
    return ratio_of(tick, bare, share);
  });
}

TimingRatio mean_timing_ratio(std::span<const Timing> runs, double share, std::uint64_t seed) {
  std::vector<double> logs;
  for (const Timing& run : runs) logs.push_back(core::math::log(ratio_of(run.tick, run.bare, share)));
  return bootstrap(runs.size(), seed, [&](auto&& run_of) {
    double sum = 0.0;
    for (std::size_t k = 0; k < logs.size(); ++k) sum += logs[run_of(k)];
    return core::math::exp(sum / static_cast<double>(logs.size()));
  });
}

int bench_timing(const TimingBench& request) {
  constexpr double goal = 1.5;
  const auto experiment =
      parse_experiment(paper_experiment().source, "platoon.toml",
                       {"robot_defaults.link=loopback", "robot_defaults.model=epuck2", "camera.source=synthetic",
                        "failure.link_bridge=2.0", "perturb=[]", fmt::format("duration={}", request.seconds)});
  if (!experiment) return complain(experiment.error().front().message()), wrong_input;
  print_out(fmt::format("lateness of ticks and of a bare thread, and their ratio, {} runs of {:g} s [us]\n{:>5}",
                        request.runs, request.seconds, "run"));
  for (const char* const what : {"p50", "p99", "p99.9"})
    print_out(fmt::format("{:>12} {:>8} {:>6}", fmt::format("tick {}", what), "bare", "ratio"));
  print_out("\n");
  std::vector<Timing> runs;
  for (std::int64_t k = 0; k < request.runs && !interrupted(); ++k) {
    auto timing = run_in_real_time(*experiment);
    if (!timing) return complain(timing.error()), device_failed;
    if (timing->priority == 0 && runs.empty()) complain(timing->no_priority);
    if (interrupted()) break;  // it was cut short
    print_out(fmt::format("{:>5}", k + 1) + line_of(*timing));
    runs.push_back(std::move(*timing));
  }
  if (runs.size() < 2) return complain("an interval needs at least two runs"), expectation_failed;
  Timing all;
  for (const Timing& run : runs) all.tick += run.tick, all.bare += run.bare;
  print_out(fmt::format("{:>5}", "all") + line_of(all));
  for (const auto& [what, share] : {std::pair("p50", 0.5), {"p99", 0.99}, {"p99.9", 0.999}}) {
    const TimingRatio found = timing_ratio(runs, share, request.seed);
    const TimingRatio mean = mean_timing_ratio(runs, share, request.seed);
    print_out(
        fmt::format("ratio of the {}: {:.2f} ({:.2f} to {:.2f}); geometric mean of the runs {:.2f} ({:.2f} to "
                    "{:.2f}){}\n",
                    what, found.ratio, found.low, found.high, mean.ratio, mean.low, mean.high,
                    share == 0.999 ? fmt::format("; goal: at most {}", goal) : ""));
    if (share == 0.999 && found.high > goal) return expectation_failed;
  }
  return done;
}

}  // namespace skein::app
