#include "app/record/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/math/elementary.h"

namespace skein::app {
namespace {

constexpr double touch_hysteresis = 1e-3;  // a pair that rubs along is one collision [m]
constexpr double one_disturbance = 0.2;    // [s]
constexpr double arrived_within = 0.01;    // [m]
constexpr std::size_t most_exact = 20'000, most_events = 10'000, most_described = 1000;

/// Where a robot is, as well as it is known; nothing of one that was never seen.
core::Pose known_place(const RobotRecord& robot) noexcept {
  if (!std::isnan(robot.truth.x)) return robot.truth;
  return robot.measurement.ever_seen() ? robot.pose : core::Pose{none, none, none};
}

/// A robot whose pose is not known makes the group's error unknown, which std::fmax would hide.
double larger(double a, double b) noexcept {
  return std::isnan(a) || std::isnan(b) ? none : std::max(a, b);
}

/// Of where the formation has them, and of where they would be on time.
double distance_from_formation(const TickRecord& record) noexcept {
  double largest = 0.0;
  for (const RobotRecord& robot : record.robots)
    largest = larger(largest, core::distance(robot.nominal.pose, robot.pose));
  return largest;
}

double tracking_error(const TickRecord& record, const Schedule& schedule) {
  double largest = 0.0;
  for (std::size_t i = 0; i < record.robots.size(); ++i)
    largest = larger(largest, core::distance(schedule.place(record, i), record.robots[i].pose));
  return largest;
}

/// Of neighbours i, i+1, as their delta.
double relative_error(const TickRecord& record) noexcept {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < record.robots.size(); ++i) {
    const RobotRecord &a = record.robots[i], &b = record.robots[i + 1];
    const double x = a.pose.x - a.nominal.pose.x - (b.pose.x - b.nominal.pose.x);
    const double y = a.pose.y - a.nominal.pose.y - (b.pose.y - b.nominal.pose.y);
    largest = larger(largest, core::math::hypot(x, y));
  }
  return largest;
}

double formation_error(const TickRecord& record) noexcept {
  double largest = 0.0;
  for (const double delta : record.delta) largest = larger(largest, std::abs(delta));
  return largest;
}

}  // namespace

bool PerturbationResult::formation_first() const noexcept {
  return settling.formation_1cm && (!settling.tracking_1cm || *settling.formation_1cm < *settling.tracking_1cm);
}

bool PerturbationResult::relative_first() const noexcept {
  return settling.relative_1cm && (!settling.tracking_1cm || *settling.relative_1cm < *settling.tracking_1cm);
}

Statistics::Statistics(const Experiment& experiment)
    : experiment_(experiment), schedule_(experiment), obstacles_(experiment.obstacles) {
  obstacles_.resize(experiment.obstacles.size() + core::ObstacleField::room_for_more);
  so_far_.name = experiment.name;
  for (const RobotSpec& robot : experiment.robots)
    if (robot.truth && robot.truth->runaway) so_far_.run_into = 0;
}

void Statistics::record(const TickRecord& record) {
  if (record.phase == Phase::finished) return note_events(record);
  so_far_.min_distance = std::fmin(so_far_.min_distance, record.min_distance);
  count_collisions(record);
  if (!counts(record.phase)) return;  // on the way to the starts
  const bool between_runs = so_far_.ticks == 0 || record.tick >= experiment_.ticks();
  if (record.phase == Phase::stopped && between_runs) {  // on the way to the starts, or back to them
    so_far_.stopped = true;
    return note_events(record);
  }
  const Sample sample{record.t,
                      formation_error(record),
                      tracking_error(record, schedule_),
                      relative_error(record),
                      record.t - record.lag,
                      distance_from_formation(record)};
  if (experiment_.avoidance.formation_waits) {
    so_far_.largest_lag = std::max(so_far_.largest_lag.value_or(0.0), record.lag);
    so_far_.final_lag = record.lag;
  }
  if (record.phase == Phase::running) {  // otherwise all references rest, which does not count as arrival
    const bool there = sample.tracking <= arrived_within &&
                       std::all_of(record.robots.begin(), record.robots.end(),
                                   [](const RobotRecord& robot) { return robot.nominal.twist == core::Twist{}; });
    if (!there)
      so_far_.arrived = none;
    else if (std::isnan(so_far_.arrived))
      so_far_.arrived = record.t;
  }
  ++so_far_.ticks;
  so_far_.duration = record.t + experiment_.period();
  so_far_.final_error = sample.tracking;
  so_far_.final_formation_error = sample.formation;
  if (so_far_.ticks > 1) so_far_.largest_period = std::fmax(so_far_.largest_period, record.period);
  if (!std::isnan(record.compute_time)) compute_times_.add(record.compute_time);
  double delay = none;
  for (const RobotRecord& robot : record.robots)
    if (!robot.is(lost)) delay = std::fmax(delay, robot.pose_age + robot.actuation_delay);
  if (!std::isnan(delay)) loop_delays_.add(delay);
  for (std::size_t stage = 0; stage < stages; ++stage) so_far_.latency[stage].add(record.latency.of[stage]);
  so_far_.latency_total.add(record.latency.total);
  if (record.phase == Phase::stopped) so_far_.stopped = true;

  note_events(record);
  for (const Event& event : record.events)
    if (is<events::Perturb, events::Move, events::Kick, events::Kidnap>(event)) disturb(record.t, sample.clock, event);
  watch_others(record);
  bands_.add(sample);  // a disturbance's own tick is the first after it
  before_.add(sample);
}

void Statistics::note_events(const TickRecord& record) {
  for (const Event& event : record.events) {
    if (so_far_.events.size() < most_events) so_far_.events.emplace_back(record.t, describe(event));
    if (const auto* const missed = std::get_if<events::DeadlineMissed>(&event))
      so_far_.missed_deadlines += missed->ticks;
  }
}

void Statistics::count_collisions(const TickRecord& record) {
  const std::size_t n = record.robots.size();
  for (const Event& event : record.events) {
    const auto* const put = std::get_if<events::PutObstacle>(&event);
    if (put && put->number < obstacles_.size()) obstacles_[put->number] = put->obstacle;
  }
  touching_.resize(n * n + n * obstacles_.size());
  drove_.resize(n);
  const auto see = [&](std::size_t pair, double gap, std::int64_t& times) {
    if (gap < 0.0 && !touching_[pair]) {
      ++times;
      touching_[pair] = true;
    } else if (gap > touch_hysteresis) {
      touching_[pair] = false;
    }
  };
  const auto runs_away = [&](std::size_t i) { return experiment_.robots[i].runs_away(record.now); };
  /// If one of the two ignores commands: a collision only if the other one drove towards it.
  std::int64_t none_of_ours = 0;
  const auto kind = [&](std::size_t i, std::size_t j) -> std::int64_t& {
    if (!runs_away(i) && !runs_away(j)) return so_far_.collisions;
    if (runs_away(i) && runs_away(j)) return none_of_ours;
    const auto [obeys, other] = runs_away(i) ? std::pair(j, i) : std::pair(i, j);
    const core::Pose from = known_place(record.robots[obeys]), to = known_place(record.robots[other]);
    const double ahead = (to.x - from.x) * core::math::cos(from.theta) + (to.y - from.y) * core::math::sin(from.theta);
    return drove_[obeys] * ahead > 1e-3 * core::distance(from, to) ? so_far_.collisions : *so_far_.run_into;
  };
  for (std::size_t i = 0; i < n; ++i) {
    const core::Pose here = known_place(record.robots[i]);
    const double radius = experiment_.robots[i].radius;
    for (std::size_t j = i + 1; j < n; ++j)
      see(i * n + j, core::distance(here, known_place(record.robots[j])) - (radius + experiment_.robots[j].radius),
          kind(i, j));
    if (runs_away(i)) continue;
    const double over =
        std::fmax(std::abs(here.x) - 0.5 * experiment_.arena_width, std::abs(here.y) - 0.5 * experiment_.arena_height) +
        radius;
    so_far_.outside = std::fmax(so_far_.outside, over);
    for (std::size_t k = 0; k < obstacles_.size(); ++k) {
      const core::Obstacle& o = obstacles_[k];
      if (o.radius <= 0.0) {
        touching_[n * n + i * obstacles_.size() + k] = false;
        continue;
      }
      const double gap = core::math::hypot(here.x - o.x, here.y - o.y) - o.radius - radius;
      so_far_.obstacle_gap = std::fmin(so_far_.obstacle_gap, gap);
      see(n * n + i * obstacles_.size() + k, gap, so_far_.collisions);
    }
  }
  for (std::size_t i = 0; i < n; ++i) drove_[i] = record.robots[i].command.v;
}

void Statistics::disturb(double t, double clock, const Event& event) {
  const std::string what = describe(event);
  const int robot = static_cast<int>(robot_of(event).value());
  if (disturbances_.size() > most_events) return;  // one more than are reported: it ends the last of them
  const bool first = disturbances_.empty();
  if (first || t - disturbances_.back().t > one_disturbance) {
    if (!first) disturbances_.back().settling = bands_.since(disturbances_.back().t, disturbances_.back().clock);
    before_ = std::exchange(bands_, {});
    disturbances_.push_back({t, clock, robot, what, std::vector<bool>(experiment_.robots.size())});
    disturbances_.back().moved[static_cast<std::size_t>(robot)] = true;
    return;
  }
  if (disturbances_.size() > 1) {  // the previous one lasted up to now
    Disturbance& last = disturbances_[disturbances_.size() - 2];
    last.settling = before_.since(last.t, last.clock);
  }
  bands_ = {};
  Disturbance& same = disturbances_.back();
  same.t = t;
  same.clock = clock;
  same.moved[static_cast<std::size_t>(robot)] = true;
  if (same.robot == robot)
    same.what = what;
  else if (same.what.size() < most_described)
    same.what += "; " + what;
  same.robot = robot;
}

void Statistics::watch_others(const TickRecord& record) {
  if (disturbances_.empty()) return;
  Disturbance& newest = disturbances_.back();
  for (std::size_t i = 0; i < record.robots.size(); ++i)
    if (!newest.moved[i])
      newest.others_away =
          std::fmax(newest.others_away, core::distance(schedule_.place(record, i), record.robots[i].pose));
}

void Statistics::Bands::add(const Sample& sample) {
  const auto update = [&](std::optional<double>& since, double error, double band) {
    if (!(error <= band))
      since.reset();
    else if (!since)
      since = sample.t;
  };
  update(formation_1cm, sample.formation, 0.01);
  update(formation_5mm, sample.formation, 0.005);
  update(tracking_1cm, sample.tracking, 0.01);
  update(tracking_5mm, sample.tracking, 0.005);
  update(relative_1cm, sample.relative, 0.01);
  update(relative_5mm, sample.relative, 0.005);
  const auto look_whole = [&](std::optional<double>& since, double band) {
    if (!(sample.whole <= band))
      since.reset();
    else if (!since)
      since = sample.clock;
  };
  look_whole(whole_1cm, 0.01);
  look_whole(whole_5mm, 0.005);
  update(whole_5mm_after, sample.whole, 0.005);
}

Settling Statistics::Bands::since(double begin, double clock) const {
  const auto after = [](const std::optional<double>& t, double since) { return t ? std::optional(*t - since) : t; };
  return {after(formation_1cm, begin), after(formation_5mm, begin), after(tracking_1cm, begin),
          after(tracking_5mm, begin),  after(relative_1cm, begin),  after(relative_5mm, begin),
          after(whole_1cm, clock),     after(whole_5mm, clock),     after(whole_5mm_after, begin)};
}

void Statistics::Durations::add(double seconds) {
  if (exact.size() < most_exact) exact.push_back(seconds);
  all.add(seconds);
}

double Statistics::Durations::median() const {
  if (exact.empty()) return none;
  if (all.total() > most_exact) return all.quantile(0.5);
  std::vector<double> values = exact;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Statistics::Summary Statistics::summary() const {
  Summary summary = so_far_;
  for (const Disturbance& d : disturbances_)
    if (summary.perturbations.size() < most_events)
      summary.perturbations.push_back({d.t, d.robot, d.what, d.settling, d.others_away});
  if (!disturbances_.empty() && disturbances_.size() <= most_events)
    summary.perturbations.back().settling = bands_.since(disturbances_.back().t, disturbances_.back().clock);
  summary.median_compute = compute_times_.median();
  if (compute_times_.all.total() > 0) summary.largest_compute = compute_times_.all.largest();
  summary.loop_delay = loop_delays_.median();
  return summary;
}

std::vector<std::string> failed_expectations(const Expectations& expect, const Statistics::Summary& summary) {
  std::vector<std::string> failed;
  const auto at_most = [&](const char* key, double limit, double value, const char* unit) {
    if (value <= limit) return;
    failed.push_back(
        std::isnan(value)
            ? fmt::format("expect.{}: expected at most {} {}, found no value", key, limit, unit)
            : fmt::format("expect.{}: expected at most {} {}, found {:.6g} {}, which is {:.4g} {} too much", key, limit,
                          unit, value, unit, value - limit, unit));
  };
  if (expect.final_error) at_most("final_error", *expect.final_error, summary.final_error, "m");
  if (const auto limit = expect.min_distance; limit && !(summary.min_distance >= *limit)) {
    failed.push_back(
        std::isnan(summary.min_distance)
            ? fmt::format("expect.min_distance: expected at least {} m, found no value", *limit)
            : fmt::format("expect.min_distance: expected at least {} m, found {:.6g} m, which is {:.4g} m too "
                          "little",
                          *limit, summary.min_distance, *limit - summary.min_distance));
  }
  if (expect.arrived) at_most("arrived", *expect.arrived, summary.arrived, "s");
  if (expect.collisions && summary.collisions > *expect.collisions)
    failed.push_back(
        fmt::format("expect.collisions: expected at most {}, found {}", *expect.collisions, summary.collisions));
  if (expect.inside && *expect.inside && summary.outside > 0.0)
    failed.push_back(fmt::format(
        "expect.inside: expected every body inside the arena, found one {:.4g} m over its edge", summary.outside));
  const auto time = [](const std::optional<double>& t) { return t ? fmt::format("after {:.2f} s", *t) : "never"; };
  if (expect.formation_first)
    for (const PerturbationResult& p : summary.perturbations)
      if (p.formation_first() != *expect.formation_first)
        failed.push_back(fmt::format(
            "expect.formation_first: expected {}, but after \"{}\" at {:g} s the formation settled "
            "to 1 cm {} and the tracking {}",
            *expect.formation_first, p.what, p.t, time(p.settling.formation_1cm), time(p.settling.tracking_1cm)));
  return failed;
}

}  // namespace skein::app
