#include "app/bench/bench_swaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "app/bench/bench_planner.h"
#include "app/bench/swap_baselines.h"
#include "app/record/statistics.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/session/session.h"
#include "app/tools/sweep.h"
#include "core/kinematics/unicycle.h"

namespace skein::app {
namespace {

constexpr double lasts = 90.0, near_enough = 0.01;     // [s], [m]
constexpr double touch = 2.0 * core::standard_radius;  // between the midpoints of two bodies that touch [m]

struct SwapOutcome {
  std::optional<double> arrived;  // all robots, for good [s]
  double least = INFINITY;        // between two midpoints [m]
};

SwapOutcome run_baseline(const Experiment& experiment, SwapMethod& method) {
  const auto reference = make_reference(experiment);
  const std::size_t n = experiment.robots.size();
  const double dt = experiment.period();
  std::vector<core::Pose> poses(n), places(n);
  std::vector<core::Twist> commands(n);
  for (std::size_t i = 0; i < n; ++i) {
    poses[i] = experiment.robots[i].start.value_or(reference->at(i, 0.0).pose);
    places[i] = reference->at(i, 1e4).pose;
  }
  SwapOutcome outcome;
  for (double t = 0.0; t < lasts; t += dt) {
    method.step(poses, places, dt, commands);
    bool there = true;
    for (std::size_t i = 0; i < n; ++i) {
      commands[i] = make_limits(experiment, i).limit(commands[i]);
      poses[i] = core::advance(poses[i], commands[i], dt);
      there = there && core::distance(poses[i], places[i]) <= near_enough;
    }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        outcome.least = std::min(outcome.least, core::distance(poses[i], poses[j]));
    if (!there)
      outcome.arrived.reset();
    else if (!outcome.arrived)
      outcome.arrived = t + dt;
  }
  return outcome;
}

tl::expected<SwapOutcome, std::string> run_skein(const Experiment& experiment) {
  Statistics statistics(experiment);
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&statistics}});
  if (!session) return tl::unexpected(session.error());
  (*session)->run();
  (*session)->close();
  const Statistics::Summary summary = statistics.summary();
  SwapOutcome outcome;
  if (!std::isnan(summary.arrived)) outcome.arrived = summary.arrived;
  outcome.least = summary.min_distance;
  return outcome;
}

struct SwapRow {
  const char* name;
  std::vector<std::string> sets;                                                         // of Skein's own
  std::unique_ptr<SwapMethod> (*make)(const core::CommandLimits&, HalfArena) = nullptr;  // or a baseline
};

}  // namespace

int bench_swaps(const SwapsBench& bench) {
  const std::vector<SwapRow> methods{
      {"planned routes", {}},
      {"detours (field, horizon 3 s)", {"avoidance.kind=field", "avoidance.horizon=3"}},
      {"the paper's field", {"avoidance.kind=field"}},
      {"ORCA, differential drive", {}, make_nh_orca},
      {"barrier certificates", {}, make_barrier_certificates},
  };
  print_out(fmt::format("{:>2} {:<30} {:>5} {:>8} {:>8} {:>8} {:>9} {:>10}\n", "n", "", "runs", "never", "p50 s",
                        "max s", "collided", "least mm"));
  bool good = true;
  for (const std::int64_t n : {4, 8, 12, 16, 20, 30})
    for (const SwapRow& method : methods) {
      std::vector<double> arrivals;
      double least = INFINITY;
      std::int64_t runs = 0, collided = 0;
      for (; runs < bench.runs && !interrupted(); ++runs) {
        std::vector<std::string> sets = method.sets;
        sets.push_back(fmt::format("duration={}", lasts));
        const auto scene = crowd_scene(n, bench.seed + static_cast<std::uint64_t>(runs), sets);
        if (!scene) {
          complain(scene.error());
          return wrong_input;
        }
        SwapOutcome outcome;
        if (method.make != nullptr) {
          const auto baseline =
              method.make(make_limits(*scene, 0), {0.5 * scene->arena_width, 0.5 * scene->arena_height});
          outcome = run_baseline(*scene, *baseline);
        } else {
          const auto made = run_skein(*scene);
          if (!made) {
            complain(made.error());
            return device_failed;
          }
          outcome = *made;
        }
        if (outcome.arrived) arrivals.push_back(*outcome.arrived);
        collided += outcome.least < touch;
        least = std::min(least, outcome.least);
      }
      const std::int64_t never = runs - static_cast<std::int64_t>(arrivals.size());
      if (&method == &methods.front()) good = good && never == 0 && collided == 0;
      print_out(fmt::format("{:>2} {:<30} {:>5} {:>8} {:>8.1f} {:>8.1f} {:>9} {:>10.1f}\n", n, method.name, runs, never,
                            quantile(arrivals, 0.5), quantile(arrivals, 1.0), collided, 1e3 * least));
    }
  return good ? done : expectation_failed;
}

}  // namespace skein::app
