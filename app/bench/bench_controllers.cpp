#include "app/bench/bench_controllers.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <thread>
#include <vector>

#include "app/bench/adversary_study.h"
#include "app/controllers/own_controller.h"
#include "app/experiment/experiment_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/resources.h"
#include "app/run/timing.h"
#include "app/tick/control_tick.h"

namespace skein::app {
namespace {

using Clock = std::chrono::steady_clock;

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values.empty() ? none : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// A tick of the paper's experiment and its controller, if it has one.
struct Line {
  Experiment experiment;
  std::unique_ptr<ControlTick> tick;
  std::unique_ptr<OwnController> own;
  bool woken;  // before it is asked, as in a run
  std::vector<double> times;
  std::int64_t late_before = 0;  // ticks without an answer before these times
};

tl::expected<Line, std::string> line(const std::vector<std::string>& sets, bool woken) {
  auto experiment = parse_experiment(paper_experiment().source, "platoon.toml", sets);
  if (!experiment) return tl::unexpected(experiment.error().front().message());
  Line made{std::move(*experiment), nullptr, nullptr, woken, {}, 0};
  made.tick = std::make_unique<ControlTick>(made.experiment);
  if (made.experiment.controller.law.own()) {
    auto own = OwnController::start(made.experiment, /*waits=*/false);
    if (!own) return tl::unexpected(own.error());
    made.own = std::move(*own);
  }
  return made;
}

/// Ticks at the tick's own rate, on poses along the reference, of one line after the other, evenly spread over the
/// period: whatever the machine does meanwhile, it does to all, and no two of them want a processor at a time.
void measure(std::vector<Line>& lines, std::int64_t first, std::int64_t ticks) {
  const Experiment& experiment = lines.front().experiment;
  const auto reference = make_reference(experiment);
  std::vector<core::Measurement> measurements(experiment.robots.size());
  const OperatorCommand start = commands::Start{};
  const auto period = std::chrono::duration<double>(experiment.period());
  const auto start_at = Clock::now() + std::chrono::milliseconds(100);
  for (std::int64_t k = first; k < first + ticks && !interrupted(); ++k) {
    const double now = static_cast<double>(k) / experiment.rate;
    for (std::size_t i = 0; i < measurements.size(); ++i) measurements[i] = {reference->at(i, now).pose, now};
    for (std::size_t each = 0; each < lines.size(); ++each) {
      Line& line = lines[each];
      const double periods =
          static_cast<double>(k - first) + static_cast<double>(each) / static_cast<double>(lines.size());
      const auto due = start_at + std::chrono::duration_cast<Clock::duration>(periods * period);
      std::this_thread::sleep_until(due - std::chrono::duration<double>(OwnController::wake_lead));
      if (line.own && line.woken) line.own->wake();
      std::this_thread::sleep_until(due);
      TickInput input;
      input.now = now;
      input.measurements = measurements;
      if (k == 0) input.commands = {&start, 1};
      const auto began = Clock::now();
      line.tick->see(input);
      if (const core::ControllerInput* const question = line.tick->ask(); question && line.own) {
        line.own->ask(*question);
        input.law = line.own->law();
        input.logged = line.own->logged();
        input.controller = line.own->state();
      }
      line.tick->decide(input);
      if (k > first) line.times.push_back(std::chrono::duration<double>(Clock::now() - began).count());
    }
  }
}

}  // namespace

int bench_controllers(const ControllersBench& bench) {
  if (const auto missing = missing_resources()) return complain(*missing), wrong_input;
  // What the control thread asks for as well; without it, a machine that is busy otherwise is measured, too.
  sched_param priority{};
  priority.sched_priority = 20;
  const bool granted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
  fmt::print("real_time_priority: {}\n", granted ? "granted" : "not granted");
  struct Case {
    const char* name;
    std::vector<std::string> sets;
    bool woken;
  };
  const std::string skein = (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "skein").string();
  // The honest one costs next to nothing: what is left is the way to another process and back.
  const std::vector<std::string> honest{fmt::format("controller.command=\"'{}' controller-host --honest\"", skein)};
  const std::vector<std::string> python{
      fmt::format("controller.command=\"/usr/bin/python3 '{}'\"", resource_folder("experiments") + "/my_law.py")};
  const Case cases[] = {
      {"built_in", {}, false},
      {"process_c", honest, true},
      {"process_c_not_woken", honest, false},
      {"process_python", python, true},
      {"process_python_not_woken", python, false},
  };
  std::vector<Line> lines;
  std::vector<const char*> names;
  for (const Case& each : cases) {
    auto made = line(each.sets, each.woken);
    if (!made) {
      fmt::print("{}: none: {}\n", each.name, made.error());
      continue;
    }
    names.push_back(each.name);
    lines.push_back(std::move(*made));
  }
  const auto late = [](const Line& line) { return line.own ? line.own->report().late : 0; };
  const auto print = [&](const char* suffix) {
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const auto p = [&](double share) { return 1e6 * percentile(lines[k].times, share); };
      const auto base = [&](double share) { return 1e6 * percentile(lines[0].times, share); };
      fmt::print(
          "tick_{}{}: p50 {:.1f} us, p99 {:.1f} us; added p50 {:.1f} us, p99 {:.1f} us; p99 ratio {:.2f}; late {}\n",
          names[k], suffix, p(0.5), p(0.99), p(0.5) - base(0.5), p(0.99) - base(0.99), p(0.99) / base(0.99),
          late(lines[k]) - lines[k].late_before);
    }
  };
  const auto ticks = static_cast<std::int64_t>(bench.seconds * lines.front().experiment.rate);
  if (ticks > 0) {
    {
      const CpuLatencyLimit awake;  // as a run with a controller of the user's has it
      fmt::print("cpu_latency_limit: {}\n", awake.granted() ? fmt::format("{} us", *awake.granted()) : awake.refused());
      measure(lines, 0, ticks);
    }
    print("");
    for (Line& line : lines) line.times.clear(), line.late_before = late(line);
    measure(lines, ticks, ticks);
    print("_processors_may_sleep");
  }
  lines.clear();

  std::vector<AdversaryOutcome> outcomes;
  for (std::int64_t run = 0; run < bench.runs && !interrupted(); ++run)
    outcomes.push_back(run_under_adversary(bench.seed + static_cast<std::uint64_t>(run), skein));
  if (outcomes.empty()) return done;
  fmt::print("{}", as_lines(outcomes, adversary_period));
  const auto bad = std::find_if_not(outcomes.begin(), outcomes.end(),
                                    [](const AdversaryOutcome& o) { return harmless(o, adversary_period); });
  if (bad == outcomes.end()) return done;
  fmt::print("first_that_did_harm: seed {} ({}): {} collisions, {:.4g} m outside, {:.1f} ms waited, {}\n", bad->seed,
             word(bad->kind), bad->collisions, bad->outside, 1e3 * bad->longest_wait,
             bad->stands ? "all stand" : "NOT all stand");
  return expectation_failed;
}

}  // namespace skein::app
