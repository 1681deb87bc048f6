#include "app/bench/bench_planner.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cmath>

#include "app/embedded/embedded.h"
#include "app/experiment/experiment_file.h"
#include "app/run/clocks.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/session/session.h"
#include "app/tick/control_tick.h"
#include "app/tools/sweep.h"
#include "core/control/coordination_law.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

constexpr int repetitions = 5;
constexpr std::int64_t lanes_each = 10;                                            // for each crowd
constexpr double most_planning = 5e-3, most_without = 0.1e-3, longest_plan = 1.5;  // [s]

class PlannerRows final : public RecordSink {
 public:
  void record(const TickRecord& record) override { rows.push_back(record); }
  std::vector<TickRecord> rows;
};

/// Of each tick of a run, how long it took and how many nodes it planned.
struct Ticks {
  std::vector<double> seconds;
  std::vector<std::size_t> nodes;
  std::vector<std::uint8_t> most_drive;
  double law = 0.0;  // the law alone, a tick of the same run [s]
  double period = 0.04;
  double aside = 0.0;  // farthest of a robot from its place [m]
  bool repeated = true;
};

tl::expected<Ticks, std::string> time_ticks(const Experiment& experiment) {
  PlannerRows run;
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&run}});
  if (!session) return tl::unexpected(session.error());
  (*session)->run();
  (*session)->close();
  const std::size_t n = experiment.robots.size();
  Ticks ticks;
  ticks.period = experiment.period();
  ticks.seconds.assign(run.rows.size(), INFINITY);
  for (const TickRecord& row : run.rows) {
    ticks.nodes.push_back(row.planning);
    const auto drive = std::count_if(row.robots.begin(), row.robots.end(),
                                     [](const RobotRecord& robot) { return robot.reference.twist != core::Twist{}; });
    ticks.most_drive.push_back(2 * static_cast<std::size_t>(drive) > n ? 1 : 0);
    for (const RobotRecord& robot : row.robots)
      ticks.aside = std::max(ticks.aside, core::distance(robot.truth, robot.nominal.pose));
  }
  std::vector<core::Measurement> measurements(n);
  const OperatorCommand start = commands::Start{};
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    ControlTick control(experiment);
    for (std::size_t k = 0; k < run.rows.size(); ++k) {
      const TickRecord& row = run.rows[k];
      for (std::size_t i = 0; i < n; ++i) measurements[i] = row.robots[i].measurement;
      TickInput input;
      input.now = row.now;
      input.measurements = measurements;
      input.events.reserve(n + 1);
      for (const Event& event : row.events)
        if (is<events::Perturb>(event)) input.events.add(event);
      if (k == 0) input.commands = {&start, 1};
      const double begin = thread_seconds();
      const TickRecord& again = control.step(input);
      ticks.seconds[k] = std::min(ticks.seconds[k], thread_seconds() - begin);
      ticks.repeated = ticks.repeated && again.planning == row.planning;
      for (std::size_t i = 0; i < n; ++i)
        ticks.repeated = ticks.repeated && again.robots[i].reference == row.robots[i].reference;
    }
  }
  const core::Gains gains = make_gains(experiment);
  std::vector<core::TrackingError> errors(n);
  std::vector<core::Twist> reference(n), command(n);
  core::LawPairs pairs(n);
  ticks.law = INFINITY;
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    const double begin = thread_seconds();
    for (const TickRecord& row : run.rows) {
      for (std::size_t i = 0; i < n; ++i) errors[i] = row.robots[i].error, reference[i] = row.robots[i].reference.twist;
      core::coordination_law(gains, errors, reference, command, pairs);
    }
    ticks.law = std::min(ticks.law, (thread_seconds() - begin) / static_cast<double>(run.rows.size()));
  }
  return ticks;
}

/// What several runs of a kind come to.
struct PlanningCost {
  std::vector<double> planning, without, whole, work;
  double law = 0.0, period = 0.04;
  std::size_t most_nodes = 0;
  bool repeated = true;

  void add(const Ticks& ticks) {
    repeated = repeated && ticks.repeated;
    law = std::max(law, ticks.law);
    period = ticks.period;
    // The first plan for all robots: until most drive. (Planning goes on for better ones.)
    double seconds = 0.0, count = 0.0;
    for (std::size_t k = 0; k < ticks.nodes.size() && ticks.nodes[k] > 0 && !ticks.most_drive[k]; ++k)
      seconds += ticks.seconds[k], ++count;
    whole.push_back(count * ticks.period);
    work.push_back(seconds);
    for (std::size_t k = 0; k < ticks.nodes.size(); ++k) {
      (ticks.nodes[k] > 0 ? planning : without).push_back(ticks.seconds[k]);
      most_nodes = std::max(most_nodes, ticks.nodes[k]);
    }
  }

  void print(const char* name) const {
    print_out(fmt::format("{:<34} {:>8} {:>9.3f} {:>9.3f} {:>9.3f} {:>8} {:>9.1f} {:>9.1f} {:>9.1f} {:>8.1f}\n", name,
                          planning.size(), 1e3 * quantile(planning, 0.5), 1e3 * quantile(planning, 0.99),
                          1e3 * quantile(planning, 1.0), most_nodes, 1e6 * quantile(without, 0.5),
                          1e6 * quantile(without, 0.99), 1e6 * law, quantile(without, 0.99) / law));
  }
};

/// How far from its place the first obstacle makes a robot drive at least: past its near side, at the shield's
/// distance. [m]
double needed_aside(const Experiment& e) {
  const core::Obstacle& obstacle = e.obstacles.front();
  double beside = INFINITY;
  for (const std::vector<core::Pose>& line : make_reference(e)->lines())
    for (const core::Pose& at : line)
      beside = std::min(beside, core::math::hypot(at.x - obstacle.x, at.y - obstacle.y));
  return std::max(0.0, obstacle.radius + e.shield.distance - core::standard_radius - beside);
}

}  // namespace

tl::expected<Experiment, std::string> crowd_scene(std::int64_t robots, std::uint64_t seed,
                                                  const std::vector<std::string>& sets) {
  Study study;
  study.experiment = "crowd.toml";
  study.text = embedded::crowd_toml;
  study.sets = sets;
  study.crowd = Study::Crowd{{robots, robots}};
  return experiment_of(study, seed);
}

int bench_planner(const PlannerBench& bench) {
  PlanningCost crowds, field, kicks, lanes;
  std::vector<double> beyond, beyond_of_field;  // what geometry needs, past an obstacle on the lane [m]
  Study lane;
  lane.experiment = "platoon.toml";
  lane.text = paper_experiment().source;
  lane.sets = {"duration=70", "perturb=[]", "avoidance.kind=plan", "obstacle=[{x=0, y=0.45, radius=0.03}]"};
  lane.vary = {{"obstacle.1.x", {-0.55, 0.65}},
               {"obstacle.1.y", {0.34, 0.56}},
               {"obstacle.1.radius", {0.03, 0.06}},
               {"reference.start", {0.45, 1.3}}};
  Study study;
  study.experiment = "platoon.toml";
  study.text = paper_experiment().source;
  study.sets = {"duration=40", "perturb=[]", "avoidance.kind=plan"};
  study.vary = {{"reference.start", {0.0, 4.196}}};
  study.hand = Study::Hand{.robots = 2};
  for (std::int64_t run = 0; run < bench.runs; ++run) {
    const std::uint64_t seed = bench.seed + static_cast<std::uint64_t>(run);
    for (const auto& [cost, scene] :
         {std::pair(&crowds, crowd_scene(30, seed)),
          std::pair(&field, crowd_scene(30, seed, {"avoidance.kind=field", "avoidance.horizon=3"})),
          std::pair(&kicks, experiment_of(study, seed))}) {
      const auto ticks = scene.and_then(time_ticks);
      if (!ticks) {
        complain(ticks.error());
        return wrong_input;
      }
      cost->add(*ticks);
    }
  }
  Study other = lane;
  other.sets.emplace_back("avoidance.kind=field");
  for (std::int64_t run = 0; run < lanes_each * bench.runs; ++run) {
    const std::uint64_t seed = bench.seed + static_cast<std::uint64_t>(run);
    const auto scene = experiment_of(lane, seed), control = experiment_of(other, seed);
    const auto planned = scene.and_then(time_ticks), by_field = control.and_then(time_ticks);
    if (!planned || !by_field) {
      complain(planned ? by_field.error() : planned.error());
      return wrong_input;
    }
    lanes.add(*planned);
    beyond.push_back(planned->aside - needed_aside(*scene));
    beyond_of_field.push_back(by_field->aside - needed_aside(*control));
  }
  print_out(fmt::format("{:<34} {:>8} {:>9} {:>9} {:>9} {:>8} {:>9} {:>9} {:>9} {:>8}\n", "", "planning", "ms p50",
                        "ms p99", "ms worst", "nodes", "other us", "p99 us", "law us", "p99/law"));
  crowds.print("30 robots, plan");
  field.print("30 robots, field (control)");
  kicks.print("platoon, one or two kicked, plan");
  lanes.print("platoon, obstacle on its lane");
  for (const auto& [name, all] : {std::pair("planned", &beyond), std::pair("field (control)", &beyond_of_field)})
    print_out(
        fmt::format("past it, farther from the lane than must be, {}: {:.1f} mm (median), {:.1f} mm (p90), {:.1f} mm "
                    "at most\n",
                    name, 1e3 * quantile(*all, 0.5), 1e3 * quantile(*all, 0.9), 1e3 * quantile(*all, 1.0)));
  print_out(fmt::format("a plan for 30: {:.2f} s of ticks (median), {:.2f} s at most; work {:.0f} and {:.0f} ms\n",
                        quantile(crowds.whole, 0.5), quantile(crowds.whole, 1.0), 1e3 * quantile(crowds.work, 0.5),
                        1e3 * quantile(crowds.work, 1.0)));
  print_out(
      fmt::format("repeated to the bit: {}\n", crowds.repeated && kicks.repeated && lanes.repeated ? "yes" : "no"));
  const double worst =
      std::max({quantile(crowds.planning, 1.0), quantile(kicks.planning, 1.0), quantile(lanes.planning, 1.0)});
  const bool reached = worst <= most_planning && quantile(crowds.without, 0.99) <= most_without &&
                       quantile(crowds.whole, 1.0) <= longest_plan && crowds.repeated && kicks.repeated &&
                       lanes.repeated;
  return reached ? done : expectation_failed;
}

}  // namespace skein::app
