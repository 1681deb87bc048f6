// Better routes for the robot that arrives last, while all robots drive.
#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"
#include "core/planning/planner.h"

namespace skein::core {
namespace {

constexpr double notice = 1.0;              // the earliest change after a trial has begun [s]
constexpr double undisturbed = 0.5;         // of that: clocks look this far ahead [s]
constexpr double nearly_there = 1.0;        // a robot that arrives this soon after the change keeps its route [s]
constexpr double gain = 0.2;                // by which the last arrival must come sooner [s]
constexpr std::size_t most_failures = 400;  // in a row; then no more trials are made

}  // namespace

/// When robot i arrives, without further delays. [s]
double Planner::arrives(std::size_t i) const noexcept {
  return robots_[i].due + robots_[i].route.duration();
}

/// Whether robot i is on a route to a place at rest, and may turn off it.
bool Planner::may_turn_off(std::size_t i, const Scene& scene) const noexcept {
  const Robot& robot = robots_[i];
  return robot.state == State::driving && rests(i, scene) && !robot.stood && !robot.needs_plan && !robot.makes_room;
}

/// Where robot j is to be on its route at time t, in the schedule that robot i was planned by. [s]
double Planner::clock_for(std::size_t j, std::size_t i, double t) const noexcept {
  return t - robots_[j].due - (i == j ? 0.0 : shift_[i * robots_.size() + j]);
}

double Planner::Improvement::random() noexcept {
  return static_cast<double>(draw() >> 11U) * 0x1p-53;
}

void Planner::Improvement::ask(std::size_t i) noexcept {
  role[i] = Role::asked;
  ++asked;
}

/// Draws the robots that may be asked to give way to the one that arrives last. False if that one cannot arrive sooner.
bool Planner::begin_improvement(const Scene& scene) noexcept {
  Improvement& g = improvement_;
  const std::size_t n = robots_.size();
  std::size_t last = n;
  for (std::size_t i = 0; i < n; ++i) {
    if (robots_[i].state == State::driving && !rests(i, scene)) return false;
    if (may_turn_off(i, scene) && (last == n || arrives(i) > arrives(last))) last = i;
  }
  if (last == n) return false;
  g.limit = arrives(last) - gain;
  // At the same samples as the routes were planned: many keep their distance only just there.
  const double since = scene.t - robots_[last].due;
  g.began = robots_[last].due + Traffic::step * std::floor(since / Traffic::step);
  g.asked = 0;
  g.searching = false;
  const double share = g.failures % 3 == 0 ? 1.0 : g.random();
  for (std::size_t i = 0; i < n; ++i) {
    using Role = Improvement::Role;
    g.role[i] = Role::keeps_on;
    if (!may_turn_off(i, scene)) continue;
    const double at = g.began + notice - robots_[i].due;
    if (at >= robots_[i].route.duration() - nearly_there) continue;
    if (i == last)
      g.ask(i);
    else if (g.random() <= share)
      g.role[i] = Role::gives_way;
    g.routes[i] = robots_[i].route;
    g.routes[i].stop_at(at, paces_[i]);
    g.from[i] = std::max(at, g.routes[i].duration());
  }
  if (g.asked == 0) return false;
  // Straight to its place, as if there were no other robot.
  Route alone = g.routes[last];
  const Pose to = goal(last, scene);
  const double leaves = std::max(g.from[last], alone.duration());
  const std::array<Leg, 1> leg{Leg{to.x, to.y, leaves, leaves}};
  return alone.append(leg, to.theta, paces_[last]) && robots_[last].due + alone.duration() <= g.limit;
}

/// Begins to search for a new route of one of the robots that turn off. The others' routes are known from the beginning
/// of the trial on.
void Planner::ask_for_improvement(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept {
  using Role = Improvement::Role;
  Improvement& g = improvement_;
  const std::size_t n = robots_.size();
  auto which = static_cast<std::size_t>(g.random() * static_cast<double>(g.asked));
  g.next = 0;
  while (g.role[g.next] != Role::asked || which-- > 0) ++g.next;
  const std::size_t i = g.next;
  Scene then = scene;
  then.t = g.began;
  for (std::size_t j = 0; j < n; ++j) {
    if (j == i) continue;
    if (!may_turn_off(j, scene)) {
      expect(j, then, nominal);
      continue;
    }
    const double clock = clock_for(j, i, g.began);
    switch (g.role[j]) {
      case Role::keeps_on:
        traffic_.drives(j, robots_[j].route, clock);
        break;
      case Role::gives_way:
      case Role::asked:
        traffic_.drives(j, g.routes[j], clock);
        traffic_.leaves(j, g.from[j] - clock + leaves_within);
        break;
      case Role::planned:
        traffic_.drives(j, g.routes[j], clock);
        break;
    }
  }
  spent_ += 10 * n;
  begin_search(i, g.routes[i].end(), g.from[i] - clock_for(i, i, g.began), scene);
  g.searching = true;
}

/// Whether robot i on its new route would come too near to robot j on its old one.
bool Planner::gets_in_the_way(std::size_t i, std::size_t j, const Scene& scene) const noexcept {
  const Improvement& g = improvement_;
  const Route &mine = g.routes[i], &theirs = robots_[j].route;
  const double fastest = 2.0 * fastest_pace_;
  const double clock = clock_for(j, i, 0.0) - clock_for(i, i, 0.0);  // theirs, when mine is 0
  const double at_end = distance(goal(i, scene), goal(j, scene));
  const double least = least_apart() - closer(i, j);
  double keep = std::max(std::min(keep_ - closer(i, j), at_end - 1e-3), least);
  const double end = std::max(mine.duration(), theirs.duration() - clock);
  std::size_t on_mine = 0, on_theirs = 0;
  for (double t = g.from[i]; t < end + Traffic::step;) {
    const Route::Position p = mine.position(t, on_mine), q = theirs.position(clock + t, on_theirs);
    const double apart = math::hypot(p.x - q.x, p.y - q.y);
    if (t == g.from[i]) keep = std::min(keep, apart - 1e-3);
    if (apart < keep) return true;
    t += Traffic::step * std::max(1.0, std::floor((apart - keep) / (fastest * Traffic::step)));
  }
  return false;
}

/// Replans the robot that arrives last, as if some of the others were absent, then those that are in its way. They
/// change to the new routes if each of them arrives sooner than the last one did before. The change lies ahead of all
/// clocks, so that the order of passing up to there stays as it is.
void Planner::improve_on_the_way(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept {
  using Role = Improvement::Role;
  Improvement& g = improvement_;
  if (g.failures >= most_failures) return;
  const auto fails = [&] { g.asked = 0, ++g.failures; };
  if (g.asked == 0 && !begin_improvement(scene)) {
    g.asked = 0;
    g.failures = most_failures;
    return;
  }
  const std::size_t n = robots_.size();
  for (std::size_t i = 0; i < n; ++i)
    if (g.role[i] != Role::keeps_on && !may_turn_off(i, scene)) return fails();
  while (spent_ < nodes_each_tick / 2) {
    if (!g.searching) ask_for_improvement(scene, nominal);
    const bool ended = continue_search();
    if (scene.t > g.began + notice - undisturbed) return fails();
    if (!ended) return;
    g.searching = false;
    const std::size_t i = g.next;
    Route& route = g.routes[i];
    const std::span<const Leg> found = search_.legs();
    std::array<Leg, Route::most_legs> legs{};
    const double clock = clock_for(i, i, g.began);
    for (std::size_t k = 0; k < found.size(); ++k)
      legs[k] = {found[k].x, found[k].y, clock + found[k].drives_at, clock + found[k].arrives_at};
    if (!search_.found() || !route.wait(g.from[i] - route.duration()) ||
        !route.append({legs.data(), found.size()}, goal(i, scene).theta, paces_[i]) ||
        robots_[i].due + route.duration() > g.limit)
      return fails();
    g.role[i] = Role::planned;
    --g.asked;
    for (std::size_t j = 0; j < n; ++j)
      if (g.role[j] == Role::gives_way && gets_in_the_way(i, j, scene)) g.ask(j);
    spent_ += 3 * n;
    if (g.asked > 0) continue;
    for (std::size_t j = 0; j < n; ++j)
      if (g.role[j] == Role::planned) robots_[j].route = g.routes[j];
    g.failures = 0;
    return;
  }
}

}  // namespace skein::core
