#include "app/bench/adversary_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "app/controllers/own_controller.h"
#include "app/experiment/experiment_file.h"
#include "app/record/statistics.h"
#include "app/session/session.h"
#include "core/simulation/random.h"

namespace skein::app {
namespace {

/// Two obstacles beside the lap, as near as the robots pass them.
constexpr std::string_view scene = R"(
name = "adversary"
duration = 10.0
[[obstacle]]
x = 0.2
y = -0.62
radius = 0.05
[[obstacle]]
x = 0.0
y = 0.31
radius = 0.04
)";

/// Says whether all robots were commanded to stand in the newest row.
class LastRow final : public RecordSink {
 public:
  void record(const TickRecord& record) override {
    ticks += record.phase == Phase::running;
    stands = std::all_of(record.robots.begin(), record.robots.end(), [](const RobotRecord& robot) {
      return robot.wheels == core::WheelSpeeds{} && robot.command == core::Twist{};
    });
  }
  std::int64_t ticks = 0;
  bool stands = true;
};

}  // namespace

AdversaryOutcome run_under_adversary(std::uint64_t seed, const std::string& program) {
  core::Random random(seed, 1);
  const auto between = [&](double low, double high) { return low + (high - low) * random.uniform(); };
  std::vector<std::string> sets{
      fmt::format("controller.command=\"'{}' controller-host --adversary {}\"",
                  program.empty() ? "/proc/self/exe" : program, seed),
      "controller.deadline=0.005",
      "controller.memory=512",
      fmt::format("controller.processes={}", random.uniform() < 0.5 ? 0 : 64),
      fmt::format("controller.failure={}", random.uniform() < 0.5 ? "hold" : "built_in"),
      fmt::format("reference.start={}", between(0.0, 4.196)),
      fmt::format("seed={}", seed),
  };
  AdversaryOutcome outcome;
  outcome.seed = seed;
  outcome.kind = adversary_of(seed);
  const auto experiment = parse_experiment(scene, "adversary.toml", sets);
  if (!experiment) {
    outcome.failure = experiment.error().front().message();
    return outcome;
  }
  Statistics statistics(*experiment);
  LastRow newest;
  SessionOptions options;
  options.sinks = {&statistics, &newest};
  auto session = Session::open(*experiment, Session::Clock::virtual_, options);
  if (!session) {
    outcome.failure = session.error();
    return outcome;
  }
  int questions = static_cast<int>(between(3.0, 14.0));  // one in 16 ticks
  outcome.stop_asked = seed % 3 == 0;
  const Phase end = (*session)->run([&] { return !outcome.stop_asked || questions-- > 0; });
  (*session)->close();
  const Statistics::Summary summary = statistics.summary();
  const ControllerReport& report = (*session)->controller()->report();
  outcome.ticks = newest.ticks;
  outcome.collisions = summary.collisions;
  outcome.min_distance = summary.min_distance;
  outcome.outside = std::max(0.0, summary.outside);
  outcome.longest_wait = report.longest;
  outcome.late = report.late;
  const std::vector<RobotStatus> robots = (*session)->robots();
  const bool acknowledged =
      std::all_of(robots.begin(), robots.end(), [](const RobotStatus& r) { return r.stop_acknowledged; });
  outcome.stands = acknowledged && (end == Phase::finished || newest.stands);
  outcome.failure = (*session)->failure().value_or("");
  return outcome;
}

bool harmless(const AdversaryOutcome& o, double period) noexcept {
  return o.collisions == 0 && o.outside <= 0.0 && o.longest_wait <= period && o.stands;
}

std::string as_lines(const std::vector<AdversaryOutcome>& outcomes, double period) {
  struct Sum {
    std::int64_t runs = 0, ticks = 0, late = 0, failed = 0, stops = 0, standing = 0, collisions = 0, outside = 0,
                 over_a_period = 0;
    double longest = 0.0, nearest = 1e9;
    void add(const AdversaryOutcome& o, double period_of_tick) {
      ++runs;
      ticks += o.ticks, late += o.late, failed += !o.failure.empty(), stops += o.stop_asked, standing += o.stands;
      collisions += o.collisions, outside += o.outside > 0.0, over_a_period += o.longest_wait > period_of_tick;
      longest = std::max(longest, o.longest_wait);
      nearest = std::fmin(nearest, o.min_distance);
    }
  };
  std::map<Adversary, Sum> kinds;
  Sum all;
  for (const AdversaryOutcome& o : outcomes) kinds[o.kind].add(o, period), all.add(o, period);
  std::string text = fmt::format("{:<12} {:>5} {:>7} {:>7} {:>6} {:>10} {:>7} {:>12} {:>11}\n", "adversary", "runs",
                                 "ticks", "late", "ended", "collisions", "outside", "nearest_mm", "longest_ms");
  const auto row = [&](std::string_view name, const Sum& s) {
    text += fmt::format("{:<12} {:>5} {:>7} {:>7} {:>6} {:>10} {:>7} {:>12.1f} {:>11.2f}\n", name, s.runs, s.ticks,
                        s.late, s.failed, s.collisions, s.outside, 1e3 * s.nearest, 1e3 * s.longest);
  };
  for (const auto& [kind, sum] : kinds) row(word(kind), sum);
  row("all", all);
  text += fmt::format("stops: {}\nstanding_at_the_end: {} of {}\nticks_more_than_a_period_late: {}\n", all.stops,
                      all.standing, all.runs, all.over_a_period);
  return text;
}

}  // namespace skein::app
