#include "app/tools/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/experiment/experiment_file.h"
#include "app/experiment/ways.h"
#include "app/record/schedule.h"
#include "app/record/statistics.h"
#include "app/session/session.h"
#include "core/math/elementary.h"

namespace skein::app {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::ordered_json;

constexpr double v_jump = 0.03;   // a larger change of v from tick to tick is a jump [m/s]
constexpr double drives = 0.005;  // a slower robot has no direction [m/s]

/// How far the robots really are from their places, and since when they have been near enough.
class Distance final : public RecordSink {
 public:
  Distance(const Experiment& experiment, double near_enough)
      : experiment_(experiment), schedule_(experiment), near_enough_(near_enough) {}

  void record(const TickRecord& record) override {
    if (!counts(record.phase)) return;
    double error = 0.0;
    farthest_way_ = 0.0;
    at_rest_ = true;
    places_.resize(record.robots.size());
    for (std::size_t i = 0; i < record.robots.size(); ++i) {
      const RobotRecord& robot = record.robots[i];
      const core::Pose& here = std::isnan(robot.truth.x) ? robot.pose : robot.truth;
      const std::optional<RobotSpec::Truth>& truth = experiment_.robots[i].truth;
      at_rest_ = at_rest_ && robot.nominal.twist.v == 0.0;
      if (starts_.size() == i) starts_.push_back(here);
      places_[i].reset();
      if (truth && truth->runaway) continue;  // it is not expected at any place
      places_[i] = schedule_.place(record, i);
      farthest_way_ = std::fmax(farthest_way_, core::distance(starts_[i], *places_[i]) / v_max(i));
      error = std::fmax(error, core::distance(*places_[i], here));
    }
    count_absent(record);
    for (const Event& event : record.events)
      if (const auto* const perturb = std::get_if<events::Perturb>(&event)) {
        if (!since_) since_ = record.t;
        farthest_ = std::fmax(farthest_, core::math::hypot(perturb->dx, perturb->dy));
      }
    if (error > near_enough_) last_far_ = record.t;
    if (error > near_enough_ || !at_rest_)
      arrived_.reset();
    else if (!arrived_)
      arrived_ = record.t;
    rows_.push_back({record.t, error});
    watch_wheels(record);
    count_jumps(record);
  }

  double limited_share() const noexcept {
    return driven_ > 0 ? static_cast<double>(limited_) / static_cast<double>(driven_) : 0.0;
  }
  double effort() const noexcept { return changes_ > 0 ? std::sqrt(squares_ / static_cast<double>(changes_)) : 0.0; }

  bool at_rest() const noexcept { return at_rest_; }  ///< all references, at the end
  /// From where every robot began straight to its last place, at v_max: the longest of these [s].
  double straight() const noexcept { return farthest_way_; }
  /// The same along the shortest paths round the obstacles; empty: for one of them there is none [s].
  std::optional<double> shortest() const {
    ShortestPaths paths(experiment_);
    double longest = 0.0;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (!places_[i]) continue;
      const std::optional<double> length = paths.length(i, starts_[i], *places_[i]);
      if (!length) return {};
      longest = std::max(longest, *length / v_max(i));
    }
    return longest;
  }
  double perturbation() const noexcept { return farthest_; }
  std::int64_t absent() const noexcept { return absent_; }
  std::int64_t places_taken() const noexcept { return places_taken_; }
  std::int64_t v_jumps() const noexcept { return v_jumps_; }
  std::int64_t reversals() const noexcept { return reversals_; }
  double final_error() const noexcept {  // of the last second
    double error = 0.0;
    for (auto row = rows_.rbegin(); row != rows_.rend() && row->t > rows_.back().t - 1.0; ++row)
      error = std::fmax(error, row->error);
    return rows_.empty() ? none : error;
  }
  std::optional<double> recovery() const noexcept {
    const double since = since_.value_or(0.0);
    if (rows_.empty() || !(final_error() <= near_enough_)) return {};
    // Where references come to rest, a robot that was never off its way has still to arrive.
    if (!since_ && arrived_) return arrived_;
    return last_far_ ? std::max(0.0, *last_far_ - since) : 0.0;
  }

 private:
  struct Row {
    double t, error;
  };
  double v_max(std::size_t i) const noexcept {
    return experiment_.robots[i].v_max.value_or(experiment_.controller.v_max);
  }
  /// Who is not at its place now, and who of these cannot be: a runaway is there.
  void count_absent(const TickRecord& record) {
    absent_ = places_taken_ = 0;
    const auto here = [&](std::size_t i) {
      const RobotRecord& robot = record.robots[i];
      return std::isnan(robot.truth.x) ? robot.pose : robot.truth;
    };
    const auto runs_away = [&](std::size_t i) { return experiment_.robots[i].runs_away(record.now); };
    for (std::size_t i = 0; i < record.robots.size(); ++i) {
      const core::Pose place = schedule_.place(record, i);
      const double shielded =
          experiment_.shield.enabled ? experiment_.shield.distance - 2.0 * core::standard_radius : 0.0;
      if (runs_away(i) || core::distance(place, here(i)) <= near_enough_) continue;
      ++absent_;
      for (std::size_t j = 0; j < record.robots.size(); ++j)
        if (runs_away(j) &&
            core::distance(place, here(j)) < experiment_.robots[i].radius + experiment_.robots[j].radius + shielded) {
          ++places_taken_;
          break;
        }
    }
  }

  void watch_wheels(const TickRecord& record) {
    before_.resize(record.robots.size());
    for (std::size_t i = 0; i < record.robots.size(); ++i) {
      const RobotRecord& robot = record.robots[i];
      limited_ += robot.limits != 0;
      ++driven_;
      const double metres = experiment_.robots[i].drive.metres_per_step() * experiment_.rate;
      if (rows_.size() > 1)
        for (const double change : {robot.wheels.left - before_[i].left, robot.wheels.right - before_[i].right})
          squares_ += core::math::squared(metres * change), ++changes_;
      before_[i] = robot.wheels;
    }
  }

  const Experiment& experiment_;
  const Schedule schedule_;
  std::vector<core::WheelSpeeds> before_;
  std::int64_t driven_ = 0, limited_ = 0, changes_ = 0;
  double squares_ = 0.0;  // of commanded wheel accelerations
  void count_jumps(const TickRecord& record) {
    in_motion_.resize(record.robots.size());
    for (std::size_t i = 0; i < in_motion_.size(); ++i) {
      const double v = record.robots[i].command.v;
      Driven& before = in_motion_[i];
      if (before.v && std::abs(v - *before.v) > v_jump) ++v_jumps_;
      before.v = v;
      if (std::abs(v) < drives) continue;
      if (before.forwards && *before.forwards != (v > 0.0)) ++reversals_;
      before.forwards = v > 0.0;
    }
  }

  struct Driven {
    std::optional<double> v;  // in the previous tick [m/s]
    std::optional<bool> forwards;
  };
  double near_enough_;
  std::vector<core::Pose> starts_;
  std::vector<std::optional<core::Pose>> places_;  // in the latest tick; empty: of a runaway
  double farthest_way_ = 0.0;                      // [s]
  bool at_rest_ = false;
  std::vector<Row> rows_;
  std::vector<Driven> in_motion_;
  std::int64_t absent_ = 0, places_taken_ = 0, v_jumps_ = 0, reversals_ = 0;
  std::optional<double> since_, last_far_, arrived_;
  double farthest_ = 0.0;
};

RunOutcome failed(std::uint64_t seed, std::string why) {
  RunOutcome outcome;
  outcome.seed = seed;
  outcome.min_distance = outcome.obstacle_gap = outcome.final_error = none;
  outcome.failure = std::move(why);
  return outcome;
}

Json json(double value) {
  return std::isfinite(value) ? Json(std::round(value * 1e6) / 1e6) : Json();
}

Json json(const SweepSummary& s) {
  std::int64_t failed_controls = 0;
  for (const SweepSummary& control : s.control) failed_controls += control.failed_runs;
  Json result{{"study", s.name},
              {"experiment", s.experiment},
              {"runs", s.runs},
              {"failed_runs", s.failed_runs + failed_controls},
              {"collisions", s.collisions},
              {"runs_with_collisions", s.runs_with_collisions},
              {"run_into", s.run_into},
              {"min_distance", json(s.min_distance)},
              {"min_distance_seed", s.min_distance_seed},
              {"obstacle_gap", json(s.obstacle_gap)},
              {"outside", json(s.outside)},
              {"runs_outside", s.runs_outside},
              {"recovered", s.recovered},
              {"recovered_share", json(s.recovered_share())},
              {"places_taken", s.places_taken},
              {"recovery_p50", json(s.recovery_p50)},
              {"recovery_p90", json(s.recovery_p90)},
              {"recovery_p99", json(s.recovery_p99)},
              {"recovery_max", json(s.recovery_max)},
              {"final_error_p50", json(s.final_error_p50)},
              {"final_error_p99", json(s.final_error_p99)},
              {"final_error_max", json(s.final_error_max)},
              {"formation_first", s.formation_first},
              {"formation_first_asked", s.formation_first_asked},
              {"formation_first_share", json(s.formation_first_share())},
              {"relative_first_share", json(s.relative_first_share())},
              {"v_jumps_max", s.v_jumps_max},
              {"v_jumps_share", json(s.v_jumps_share())},
              {"reversals_max", s.reversals_max},
              {"reversals_share", json(s.reversals_share())},
              {"bad_seeds", s.bad_seeds}};
  if (!std::isnan(s.lag_max))
    result.update({{"whole_p50", json(s.whole_p50)},
                   {"whole_p99", json(s.whole_p99)},
                   {"whole_max", json(s.whole_max)},
                   {"whole_after_p50", json(s.whole_after_p50)},
                   {"whole_after_p99", json(s.whole_after_p99)},
                   {"whole_after_max", json(s.whole_after_max)},
                   {"lag_p50", json(s.lag_p50)},
                   {"lag_max", json(s.lag_max)}});
  if (!std::isnan(s.over_straight_max))
    result.update({{"over_straight_p50", json(s.over_straight_p50)},
                   {"over_straight_p99", json(s.over_straight_p99)},
                   {"over_straight_max", json(s.over_straight_max)}});
  if (!std::isnan(s.over_shortest_max))
    result.update({{"over_shortest_p50", json(s.over_shortest_p50)},
                   {"over_shortest_p99", json(s.over_shortest_p99)},
                   {"over_shortest_max", json(s.over_shortest_max)}});
  for (const SweepSummary& control : s.control)
    result.update({{"control_failed_runs", control.failed_runs},
                   {"control_collisions", control.collisions},
                   {"control_runs_with_collisions", control.runs_with_collisions},
                   {"control_runs_outside", control.runs_outside},
                   {"control_recovered_share", json(control.recovered_share())},
                   {"control_places_taken", control.places_taken},
                   {"control_recovery_p50", json(control.recovery_p50)},
                   {"control_recovery_p99", json(control.recovery_p99)},
                   {"control_recovery_max", json(control.recovery_max)},
                   {"control_formation_first_share", json(control.formation_first_share())},
                   {"control_relative_first_share", json(control.relative_first_share())}});
  return result;
}

double share(std::int64_t part, std::int64_t whole) noexcept {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : none;
}

}  // namespace

tl::expected<Experiment, std::string> experiment_of(const Study& study, std::uint64_t seed, bool control) {
  auto sets = variation(study, seed);
  if (!sets) return tl::unexpected(sets.error());
  sets->insert(sets->begin(), study.sets.begin(), study.sets.end());
  if (control) sets->insert(sets->end(), study.control.begin(), study.control.end());
  return parse_experiment(study.text, study.experiment, *sets).map_error([](const std::vector<Problem>& problems) {
    return problems.front().message();
  });
}

Study compared_study(const Study& study, const std::string& name) {
  Study other = study;
  for (const auto& [found, sets] : study.compare)
    if (found == name) other.sets.insert(other.sets.end(), sets.begin(), sets.end());
  return other;
}

RunOutcome run_one(const Study& study, std::uint64_t seed, bool control) {
  const auto experiment = experiment_of(study, seed, control);
  if (!experiment) return failed(seed, experiment.error());

  Statistics statistics(*experiment);
  Distance distance(*experiment, study.recovered_within);
  auto session = Session::open(*experiment, Session::Clock::virtual_, {false, {&statistics, &distance}});
  if (!session) return failed(seed, session.error());
  (*session)->run();
  (*session)->close();
  if (const auto failure = (*session)->failure()) return failed(seed, *failure);

  const Statistics::Summary summary = statistics.summary();
  RunOutcome outcome;
  outcome.seed = seed;
  outcome.robots = static_cast<std::int64_t>(experiment->robots.size());
  outcome.perturbation = distance.perturbation();
  outcome.collisions = summary.collisions;
  outcome.run_into = summary.run_into.value_or(0);
  outcome.min_distance = summary.min_distance;
  outcome.obstacle_gap = summary.obstacle_gap;
  outcome.final_error = distance.final_error();
  outcome.recovery = distance.recovery();
  if (outcome.perturbation == 0.0 && distance.at_rest()) {
    outcome.straight = distance.straight();
    outcome.shortest = distance.shortest();
  }
  outcome.outside = summary.outside;
  outcome.absent = distance.absent();
  outcome.places_taken = distance.places_taken();
  outcome.v_jumps = distance.v_jumps();
  outcome.reversals = distance.reversals();
  const auto all = [&](bool (PerturbationResult::*first)() const noexcept) {
    return std::all_of(summary.perturbations.begin(), summary.perturbations.end(),
                       [&](const PerturbationResult& p) { return (p.*first)(); });
  };
  for (const auto& [slowest, settled] : {std::pair(&RunOutcome::formation_settled, &Settling::formation_1cm),
                                         {&RunOutcome::relative_settled, &Settling::relative_1cm},
                                         {&RunOutcome::tracking_settled, &Settling::tracking_1cm}})
    for (const PerturbationResult& p : summary.perturbations) {
      const std::optional<double>& here = p.settling.*settled;
      outcome.*slowest = here ? std::max(outcome.*slowest, here) : std::nullopt;
      if (!here) break;
    }
  outcome.lag = summary.largest_lag;
  if (outcome.lag)
    for (const auto& [slowest, settled] :
         {std::pair(&RunOutcome::whole, &Settling::whole_5mm), {&RunOutcome::whole_after, &Settling::whole_5mm_after}})
      for (const PerturbationResult& p : summary.perturbations) {
        const std::optional<double>& here = p.settling.*settled;
        outcome.*slowest = here ? std::max(outcome.*slowest, here) : std::nullopt;
        if (!here) break;
      }
  outcome.limited_share = distance.limited_share();
  outcome.effort = distance.effort();
  if (outcome.perturbation > study.formation_first_over)
    outcome.relative_first = all(&PerturbationResult::relative_first);
  if (outcome.perturbation > study.formation_first_over)
    outcome.formation_first = all(&PerturbationResult::formation_first);
  return outcome;
}

std::vector<RunOutcome> sweep(const Study& study, unsigned threads, const std::function<bool(std::size_t)>& progress,
                              bool control, Part part) {
  const std::int64_t runs = (study.runs - part.index + part.of) / part.of;
  std::vector<std::optional<RunOutcome>> outcomes(static_cast<std::size_t>(runs));
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<bool> ended{false};
  {
    std::vector<std::jthread> workers;
    for (unsigned k = 0; k < threads; ++k)
      workers.emplace_back([&] {
        for (std::size_t run = next++; run < outcomes.size() && !ended; run = next++) {
          const std::uint64_t seed = study.seed + run * static_cast<std::uint64_t>(part.of) + part.index - 1;
          try {
            outcomes[run] = run_one(study, seed, control);
          } catch (const std::exception& error) {
            outcomes[run] = failed(seed, error.what());
          }
          ++done;
        }
      });
    while (done < outcomes.size() && !ended) {
      std::this_thread::sleep_for(10ms);
      if (!progress(done)) ended = true;
    }
  }
  std::vector<RunOutcome> made;
  for (std::optional<RunOutcome>& outcome : outcomes)
    if (outcome) made.push_back(std::move(*outcome));
  return made;
}

double quantile(std::vector<double> values, double share_of_all) {
  if (values.empty()) return none;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(share_of_all * static_cast<double>(values.size())));
  return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
}

double SweepSummary::recovered_share() const noexcept {
  return share(recovered, runs);
}
double SweepSummary::v_jumps_share() const noexcept {
  return share(with_v_jumps, runs - failed_runs);
}
double SweepSummary::reversals_share() const noexcept {
  return share(with_reversals, runs - failed_runs);
}
double SweepSummary::relative_first_share() const noexcept {
  return share(relative_first, formation_first_asked);
}
double SweepSummary::formation_first_share() const noexcept {
  return share(formation_first, formation_first_asked);
}

SweepSummary summarise(const Study& study, const std::vector<RunOutcome>& outcomes,
                       const std::vector<RunOutcome>& control) {
  SweepSummary s;
  s.name = study.name;
  s.experiment = study.experiment;
  s.runs = static_cast<std::int64_t>(outcomes.size());
  s.min_distance = s.obstacle_gap = none;
  std::vector<double> recoveries, over_straight, over_shortest, errors, wholes, wholes_after, lags;
  for (const RunOutcome& o : outcomes) {
    if (!o.failure.empty() || o.collided() || !o.recovery) s.bad_seeds.push_back(o.seed);
    if (!o.failure.empty()) {
      ++s.failed_runs;
      continue;
    }
    s.collisions += o.collisions;
    s.runs_with_collisions += o.collided();
    s.run_into += o.run_into;
    if (!(o.min_distance >= s.min_distance)) s.min_distance = o.min_distance, s.min_distance_seed = o.seed;
    s.obstacle_gap = std::fmin(s.obstacle_gap, o.obstacle_gap);
    errors.push_back(o.final_error);
    if (o.recovery) recoveries.push_back(*o.recovery);
    if (o.recovery && o.straight && *o.straight > 0.0) over_straight.push_back(*o.recovery / *o.straight);
    if (o.recovery && o.shortest && *o.shortest > 0.0) over_shortest.push_back(*o.recovery / *o.shortest);
    s.places_taken += o.shut_out();
    s.runs_outside += o.outside > 0.0;
    if (o.whole) wholes.push_back(*o.whole);
    if (o.whole_after) wholes_after.push_back(*o.whole_after);
    if (o.lag) lags.push_back(*o.lag);
    s.formation_first_asked += o.formation_first.has_value();
    s.formation_first += o.formation_first.value_or(false);
    s.relative_first += o.relative_first.value_or(false);
    s.outside = std::fmax(s.outside, o.outside);
    s.v_jumps_max = std::max(s.v_jumps_max, o.v_jumps);
    s.reversals_max = std::max(s.reversals_max, o.reversals);
    s.with_v_jumps += o.v_jumps > 0;
    s.with_reversals += o.reversals > 1;
  }
  s.recovered = static_cast<std::int64_t>(recoveries.size());
  s.recovery_p50 = quantile(recoveries, 0.5);
  s.recovery_p90 = quantile(recoveries, 0.9);
  s.recovery_p99 = quantile(recoveries, 0.99);
  s.recovery_max = quantile(recoveries, 1.0);
  s.over_straight_p50 = quantile(over_straight, 0.5);
  s.over_straight_p99 = quantile(over_straight, 0.99);
  s.over_straight_max = quantile(over_straight, 1.0);
  s.over_shortest_p50 = quantile(over_shortest, 0.5);
  s.over_shortest_p99 = quantile(over_shortest, 0.99);
  s.over_shortest_max = quantile(over_shortest, 1.0);
  s.whole_p50 = quantile(wholes, 0.5);
  s.whole_p99 = quantile(wholes, 0.99);
  s.whole_max = quantile(wholes, 1.0);
  s.whole_after_p50 = quantile(wholes_after, 0.5);
  s.whole_after_p99 = quantile(wholes_after, 0.99);
  s.whole_after_max = quantile(wholes_after, 1.0);
  s.lag_p50 = quantile(lags, 0.5);
  s.lag_max = quantile(lags, 1.0);
  s.final_error_p50 = quantile(errors, 0.5);
  s.final_error_p99 = quantile(errors, 0.99);
  s.final_error_max = quantile(errors, 1.0);
  if (!control.empty()) s.control.push_back(summarise(study, control));
  std::map<std::int64_t, std::vector<RunOutcome>> by_robots;
  for (const RunOutcome& o : outcomes)
    if (o.failure.empty()) by_robots[o.robots].push_back(o);
  if (by_robots.size() == 1) s.robots = by_robots.begin()->first;
  if (by_robots.size() > 1)
    for (const auto& [robots, runs] : by_robots) s.by_robots.push_back(summarise(study, runs));
  return s;
}

std::string as_lines(const SweepSummary& summary) {
  std::string lines;
  const Json all = json(summary);
  for (const auto& [key, value] : all.items()) {
    std::string text;
    if (value.is_array()) {  // the first few: --csv has them all
      constexpr std::size_t most = 10;
      for (std::size_t i = 0; i < std::min(most, value.size()); ++i) text += (i ? " " : "") + value[i].dump();
      if (value.size() > most) text += fmt::format(" and {} more", value.size() - most);
    } else {
      text = value.is_string() ? value.get<std::string>() : value.dump();
    }
    lines += fmt::format("{}: {}\n", key, value.is_null() || text.empty() ? "none" : text);
  }
  return lines;
}

std::string as_table(const std::vector<std::pair<std::string, SweepSummary>>& rows) {
  std::string text =
      fmt::format("{:<18} {:>5} {:>10} {:>9} {:>6} {:>6} {:>6} {:>6} {:>10} {:>9} {:>9}\n", "", "runs", "collisions",
                  "recovered", "p50", "p90", "p99", "max", "formation", "relative", "error_p99");
  for (const auto& [name, s] : rows)
    text +=
        fmt::format("{:<18} {:>5} {:>10} {:>9.3f} {:>6.1f} {:>6.1f} {:>6.1f} {:>6.1f} {:>10.3f} {:>9.3f} {:>9.4f}\n",
                    name, s.runs, s.collisions, s.recovered_share(), s.recovery_p50, s.recovery_p90, s.recovery_p99,
                    s.recovery_max, s.formation_first_share(), s.relative_first_share(), s.final_error_p99);
  return text;
}

std::string as_table_by_robots(const SweepSummary& summary) {
  if (summary.by_robots.empty()) return {};
  std::string text =
      fmt::format("{:>6} {:>6} {:>10} {:>7} {:>9} {:>6} {:>6} {:>6} {:>13} {:>12}\n", "robots", "runs", "collisions",
                  "outside", "recovered", "p50", "p99", "max", "over_straight", "min_distance");
  for (const SweepSummary& s : summary.by_robots)
    text += fmt::format("{:>6} {:>6} {:>10} {:>7} {:>9} {:>6.1f} {:>6.1f} {:>6.1f} {:>13.2f} {:>12.4f}\n", s.robots,
                        s.runs, s.collisions, s.runs_outside, s.recovered, s.recovery_p50, s.recovery_p99,
                        s.recovery_max, s.over_straight_max, s.min_distance);
  return text;
}

std::string as_json(const SweepSummary& summary, const std::vector<std::pair<std::string, SweepSummary>>& compared) {
  Json all = json(summary);
  for (const SweepSummary& of : summary.by_robots) all["by_robots"][std::to_string(of.robots)] = json(of);
  for (const auto& [name, other] : compared) all["compare"][name] = json(other);
  return all.dump(2, ' ', false, Json::error_handler_t::replace);
}

std::vector<std::string> failed_expectations(const Study::Expect& expect, const SweepSummary& summary) {
  std::vector<std::string> sentences;
  if (expect.collisions && summary.collisions > *expect.collisions)
    sentences.push_back(
        fmt::format("expect.collisions: expected at most {}, found {}", *expect.collisions, summary.collisions));
  if (expect.inside && *expect.inside && summary.outside > 0.0)
    sentences.push_back(fmt::format(
        "expect.inside: expected every body inside the arena, found one {:.4g} m over its edge", summary.outside));
  const auto at_least = [&](const char* key, const std::optional<double>& least, double found) {
    if (least && !(found >= *least))
      sentences.push_back(fmt::format("expect.{}: expected a share of at least {}, found {:.6g}", key, *least, found));
  };
  at_least("recovered", expect.recovered, summary.recovered_share());
  at_least("formation_first", expect.formation_first, summary.formation_first_share());
  return sentences;
}

}  // namespace skein::app
