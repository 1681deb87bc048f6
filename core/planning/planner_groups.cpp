// Whom to plan, when, and in what order.
#include "core/math/elementary.h"
#include "core/planning/planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace skein::core {
namespace {

// After no route was found. Each attempt stops all robots and replans them, so that attempts become less and less
// frequent. [s]
constexpr double try_again = 1.0, try_again_at_last = 8.0;
constexpr double lead_each = 0.016;   // planning a robot takes about so long [s]
constexpr double longest_lead = 0.8;  // [s]
constexpr int most_attempts = 40;
constexpr double longest_planning = 4.0;  // then a robot without a route is left standing, and the others drive [s]
constexpr double longest_anew = 12.0;     // the same where all have given way, and none can drive before [s]
constexpr int most_improvements = 6;
constexpr double good_enough = 1.12;  // against the longest of the robots' straight lines
constexpr double slowest = 0.005;     // who is slower stands [m/s]
constexpr double at_place = 0.005;    // who is so near is there [m]
constexpr double horizon = 45.0;      // of places that move [s]
constexpr double pressed_on = 0.012;  // who is so far from its reference has been held back or pushed on [m]
constexpr double back_within = 4.0;   // who has been pushed on is expected to take so long to its place [s]

}  // namespace

/// Puts into the traffic what robot j is expected to do.
void Planner::expect(std::size_t j, const Scene& scene, std::span<const ReferencePoint> nominal) noexcept {
  const Robot& robot = robots_[j];
  const Pose& pose = scene.poses[j];
  if (std::isnan(pose.x)) return traffic_.remove(j);
  if (stands(j, scene) || robot.state == State::waiting) return traffic_.stands(j, pose.x, pose.y);
  if (robot.state == State::driving && !rests(j, scene))
    return traffic_.joins(j, robot.route, robot.clock, robot.joins, {*reference_, scene.t, horizon});
  if (robot.state == State::driving) return traffic_.drives(j, robot.route, robot.clock);
  if (robot.state == State::yielding) return traffic_.follows(j, {*reference_, scene.t, horizon, yield_});
  if (robot.state == State::passing) return traffic_.follows(j, {*reference_, scene.t, horizon}, robot.aside);
  if (scene.to_starts || nominal[j].twist == Twist{}) {
    if (scene.to_starts || formation_t_ >= rest_from_[j])
      return traffic_.stands(j, nominal[j].pose.x, nominal[j].pose.y);
  }
  const double most = rest_from_[j] < never ? std::max(0.0, rest_from_[j] - formation_t_) + 0.2 : horizon;
  traffic_.follows(j, {*reference_, scene.t, std::min(most, Traffic::step * Traffic::steps)});
  // The shield may have pushed it on, for one that wants to pass: a route past where it should be would do so again.
  if (!rests(j, scene) && distance(pose, nominal[j].pose) > pressed_on + 2.0 * scene.doubt)
    traffic_.shift(j, pose.x - nominal[j].pose.x, pose.y - nominal[j].pose.y, back_within);
}

/// Whose nominal ways to rest meet: those of all robots when planning begins, later those of robots that are seen for
/// the first time. A group that is being planned took these as absent, and begins anew with them.
void Planner::find_conflicts(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept {
  const std::size_t n = robots_.size();
  const auto is_new = [this](std::size_t i) { return robots_[i].is_new; };
  if (std::none_of(robots_.begin(), robots_.end(), [](const Robot& robot) { return robot.is_new; })) return;
  improvement_.asked = 0;
  improvement_.searching = false;
  const bool plans = group_.active;
  if (plans) begin_group_anew();
  spent_ += n * n;
  for (std::size_t j = 0; j < n; ++j) expect(j, scene, nominal);
  const auto meets_another = [&](std::size_t i) {
    if (rests(i, scene) && (is_new(i) || robots_[i].state == State::nominal)) robots_[i].needs_plan = true;
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (!traffic_.present(i)) continue;
    for (std::size_t j = i + 1; j < n; ++j) {
      if ((!is_new(i) && !is_new(j)) || !traffic_.present(j) || (!rests(i, scene) && !rests(j, scene))) continue;
      const std::size_t end = std::max(traffic_.still_from(i), traffic_.still_from(j));
      double least = never;
      for (std::size_t k = 0; k <= end; k += 2)
        least = std::min(least, math::hypot(traffic_.x(i, k) - traffic_.x(j, k), traffic_.y(i, k) - traffic_.y(j, k)));
      if (least < keep_ - closer(i, j)) meets_another(i), meets_another(j);
    }
    if (!is_new(i) || !rests(i, scene)) continue;
    // Nobody knows yet where the members will drive.
    if (plans && !is_back(i, scene, nominal[i].pose)) robots_[i].needs_plan = true;
    // Obstacles on its way.
    for (std::size_t k = 0; k <= traffic_.still_from(i); k += 2)
      if (!lattice(i).free(traffic_.x(i, k), traffic_.y(i, k)) && k > 0) robots_[i].needs_plan = true;
  }
}

void Planner::set_off(std::size_t i, double due) noexcept {
  Robot& robot = robots_[i];
  robot.due = due;
  robot.clock = now_ - due;
  robot.rate = 1.0;
  robot.state = State::driving;
  robot.held_for = robot.barred = 0.0;
  robot.no_way = robot.makes_room;
  robot.needs_plan = robot.all_anew = false;
  robot.patience = 0.0;
  // Its plan took the others as they are; theirs knew nothing of it. A group whose planning took longer than its lead
  // took them as they were that much before. That delay is not added: whoever is ahead of a plan's order may stand
  // where another is to pass first. With it a robot that is fetched late waited less (13 ticks instead of 131 in three
  // crowds of 20), but Planner.LetsThoseDriveWhoHaveAWay never ended, and crowds of 30 took as long.
  for (std::size_t j = 0; j < robots_.size(); ++j) {
    if (j == i) continue;
    const bool drives = robots_[j].state == State::driving;
    const double late = drives ? lag(j) : 0.0;
    shift_[i * robots_.size() + j] = late;
    shift_[j * robots_.size() + i] = -late;
  }
}

/// Robot i brakes from whatever it does, and stands until it has a plan.
Planner::Start Planner::begin_route(std::size_t i, const Scene& scene) noexcept {
  Robot& robot = robots_[i];
  const Pose& pose = scene.poses[i];
  // A robot that drives goes on from its reference, so that noise does not become a jump; one that stands, from where
  // it is. On a route, this tick's reference is not computed yet: from that of the previous tick, the robot would be
  // driven back.
  const bool on_route = robot.state == State::waiting || (robot.state == State::driving && rests(i, scene));
  const Pose on = on_route ? robot.route.at(robot.clock).pose : robot.reference.pose;
  const double v = std::abs(scene.commands[i].v) < slowest ? 0.0 : scene.commands[i].v;
  // One that the shield holds back on its way to a place that drives on would press on without end, from a reference
  // that is always past what holds it back.
  const double near = rests(i, scene) ? put_elsewhere : pressed_on + 2.0 * scene.doubt;
  const bool tracks =
      v != 0.0 && distance(pose, on) < near && std::abs(wrap_angle(pose.theta - on.theta)) < looks_elsewhere;
  const Pose from = tracks ? on : pose;
  robot.route.brake(from, v, paces_[i]);
  group_.from[i] = robot.route.end();
  group_.stands[i] = robot.route.duration();
  robot.clock = 0.0;
  robot.rate = 1.0;
  robot.state = State::waiting;
  robot.makes_room = false;
  return {from, v};
}

/// Robot i stands where its route ends, and a way is searched for again after a while.
void Planner::wait_for_a_way(std::size_t i) noexcept {
  Robot& robot = robots_[i];
  robot.state = State::waiting;
  robot.needs_plan = robot.no_way = true;
  robot.patience = std::clamp(2.0 * robot.patience, try_again, try_again_at_last);
  robot.retry = now_ + robot.patience;
}

/// A hand moved robot i while it stood without a plan: it is planned from there at once. A group that is being planned
/// took it as where it was, and begins anew.
void Planner::wait_here(std::size_t i, const Pose& pose) noexcept {
  Robot& robot = robots_[i];
  robot.route.stand(pose);
  robot.clock = robot.retry = robot.patience = 0.0;
  robot.reference = {pose, {}};
  if (group_.active && group_.member[i]) begin_group_anew();
}

/// What the members were being planned through has changed.
void Planner::begin_group_anew() noexcept {
  Group& g = group_;
  for (const std::size_t j : g.order) {
    robots_[j].needs_plan = true;
    if (g.give_way) robots_[j].gives_way = false;  // nobody has done so yet
  }
  g.active = false;
}

void Planner::begin_search(std::size_t i, const Pose& from, double begins, const Scene& scene) noexcept {
  RouteSearch::Query query;
  query.robot = i;
  query.from = from;
  query.begins = begins;
  query.to = goal(i, scene);
  query.keep = keep_;
  query.least = least_apart();
  query.pace = paces_[i];
  query.smaller = setup_.smaller;
  if (robots_[i].makes_room) query.away_from = group_.places, query.lets_pass = group_.active && group_.give_way;
  search_.look_at(lattice(i), traffic_);
  search_.begin(query, traffic_);
  spent_ += search_.found() ? 60 : 500;  // the stamps and the estimate
}

bool Planner::continue_search() noexcept {
  if (search_.searching())
    spent_ += search_.advance(std::max<std::size_t>(200, nodes_each_tick - std::min(nodes_each_tick, spent_)));
  return !search_.searching();
}

void Planner::begin_group(const Scene& scene, std::span<const ReferencePoint> nominal, bool everybody) noexcept {
  Group& g = group_;
  const std::size_t n = robots_.size();
  g.order.clear();
  std::fill(g.planned.begin(), g.planned.end(), std::uint8_t{0});
  for (std::size_t i = 0; i < n; ++i) {
    const bool can = rests(i, scene) && !stands(i, scene) && !std::isnan(scene.poses[i].x);
    g.member[i] = can && (robots_[i].needs_plan || everybody);
    if (g.member[i]) g.order.push_back(i);
  }
  if (g.order.empty()) return;
  g.active = true;
  g.asking = false;
  g.best_arrival = never;
  g.improvements = 0;
  g.everybody = everybody;
  g.others = Group::Others::leave;
  g.next = 0;
  g.attempt = 0;
  g.give_way = false;
  g.began = scene.t;
  g.until = scene.t + (all_gave_way() ? longest_anew : longest_planning);
  const auto count = static_cast<double>(g.order.size());
  g.lead = count > 2.0 ? std::min(longest_lead, lead_each * count) : 0.0;
  for (const std::size_t i : g.order) {
    begin_route(i, scene);
    robots_[i].needs_plan = robots_[i].all_anew = false;
    robots_[i].makes_room = is_taken(i, scene);
    g.lead = std::max(g.lead, g.stands[i]);  // a route that begins late does not repeat the braking
  }
  for (std::size_t j = 0; j < n; ++j)
    if (!g.member[j]) expect(j, scene, nominal);
  for (std::size_t j = 0; j < n; ++j) g.places[j] = rests(j, scene) ? goal(j, scene) : Pose{never, never, 0.0};
  spent_ += 15 * n;
  // Robots that make room come last: by then it is known where the others drive. The longest way first. (stable_sort
  // would allocate.)
  std::sort(g.order.begin(), g.order.end(), [&](std::size_t a, std::size_t b) {
    if (robots_[a].makes_room != robots_[b].makes_room) return robots_[b].makes_room;
    const double way_a = distance(g.from[a], goal(a, scene)), way_b = distance(g.from[b], goal(b, scene));
    return way_a != way_b ? way_a > way_b : a < b;
  });
}

/// Asks for a plan of the members, and of the robots that follow their references to places at rest. False if there are
/// none of those.
bool Planner::include_who_follows(const Scene& scene) noexcept {
  bool more = false;
  for (std::size_t j = 0; j < robots_.size(); ++j)
    if (robots_[j].state == State::nominal && rests(j, scene) && !scene.to_starts && formation_t_ < rest_from_[j] &&
        !stands(j, scene) && !std::isnan(scene.poses[j].x))
      robots_[j].needs_plan = more = true;
  if (more)
    for (const std::size_t i : group_.order) robots_[i].needs_plan = true;
  return more;
}

bool Planner::all_gave_way() const noexcept {
  return std::all_of(group_.order.begin(), group_.order.end(), [&](std::size_t j) { return robots_[j].gives_way; });
}

/// No order of the members has helped, as where two in a dead end are to change places: all go where others can pass,
/// and are planned anew from there. False if they have done that already.
bool Planner::let_all_give_way() noexcept {
  Group& g = group_;
  if (!g.everybody || g.give_way || all_gave_way()) return false;
  g.give_way = true;
  for (const std::size_t j : g.order) robots_[j].makes_room = robots_[j].gives_way = true;
  g.attempt = 0;
  g.until = now_ + longest_planning;
  return true;
}

/// One robot after the other; one without a route goes to the front, and all begin anew.
void Planner::go_on_with_group(const Scene& scene, std::span<const ReferencePoint> nominal) noexcept {
  Group& g = group_;
  while (g.active && spent_ < nodes_each_tick) {
    if (g.next == g.order.size()) {
      if (improve(scene)) continue;
      end_group(scene);
      return;
    }
    const std::size_t i = g.order[g.next];
    if (!g.asking) {
      for (const std::size_t j : g.order) {
        if (j == i || g.planned[j]) continue;
        const Pose& p = g.from[j];
        switch (g.others) {
          case Group::Others::leave:
            traffic_.stands(j, p.x, p.y, leaves_within);
            break;
          case Group::Others::stay:
            traffic_.stands(j, p.x, p.y);
            break;
          case Group::Others::absent:
            traffic_.remove(j);
            break;
        }
      }
      begin_search(i, g.from[i], std::max(g.stands[i], g.lead), scene);
      g.asking = true;
    }
    if (!continue_search()) return;
    g.asking = false;
    Route& route = g.routes[i];
    route = robots_[i].route;  // that it brakes along
    const auto stays = [&] {
      traffic_.stands(i, g.from[i].x, g.from[i].y);
      g.planned[i] = g.member[i] = 0;
      g.order.erase(g.order.begin() + static_cast<std::ptrdiff_t>(g.next));
      wait_for_a_way(i);
    };
    const bool at_its_place = g.give_way && distance(g.from[i], goal(i, scene)) < at_place;
    if (search_.found() && search_.legs().empty() && !at_its_place) {  // it makes room, and blocks no other robot
      stays();
      g.others = Group::Others::leave;
      continue;
    }
    if (search_.found() && route.append(search_.legs(), goal(i, scene).theta, paces_[i])) {
      traffic_.drives(i, route, 0.0);
      g.planned[i] = 1;
      g.others = Group::Others::leave;
      ++g.next;
      continue;
    }
    if (g.next + 1 < g.order.size()) switch (g.others) {
        case Group::Others::leave:
          g.others = Group::Others::stay;
          continue;
        case Group::Others::stay:
          g.others = Group::Others::absent;
          continue;
        case Group::Others::absent:
          break;
      }
    ++g.attempt;
    if (g.best_arrival < never) {  // the plan that there is, is good enough
      end_group(scene);
      return;
    }
    // The order of the members does not help: robots that are not planned may be in the way.
    if ((g.next == 0 || g.attempt > 1) && include_who_follows(scene)) {
      begin_group(scene, nominal, g.everybody);
      continue;
    }
    bool gives_up = g.attempt > most_attempts || scene.t > g.until;
    if (gives_up && g.next > 0 && !robots_[i].makes_room && let_all_give_way()) {
      gives_up = false;
    } else if (gives_up || g.next == 0) {  // first and yet no way
      // It waits where it blocks no other robot, like one whose place is taken, and is planned last. If it cannot go
      // there either, it stands where it is.
      if (std::exchange(robots_[i].makes_room, true))
        stays();
      else
        std::rotate(g.order.begin() + static_cast<std::ptrdiff_t>(g.next),
                    g.order.begin() + static_cast<std::ptrdiff_t>(g.next + 1), g.order.end());
    } else {
      std::rotate(g.order.begin(), g.order.begin() + static_cast<std::ptrdiff_t>(g.next),
                  g.order.begin() + static_cast<std::ptrdiff_t>(g.next + 1));
    }
    if (!gives_up) {
      for (const std::size_t j : g.order) g.planned[j] = 0;
      g.next = 0;
      g.others = Group::Others::leave;
    }
  }
}

/// All have routes. Keeps them if they are the best so far; whether to try again with the robot that arrives last in
/// front.
bool Planner::improve(const Scene& scene) noexcept {
  Group& g = group_;
  double last = 0.0, soonest = 0.0;
  std::size_t latest = 0;
  for (std::size_t k = 0; k < g.order.size(); ++k) {
    const std::size_t i = g.order[k];
    const Pose to = goal(i, scene);
    if (robots_[i].makes_room) continue;
    const double alone = std::max(g.stands[i], g.lead) + distance(g.from[i], to) / paces_[i].v;
    soonest = std::max(soonest, alone);
    if (g.routes[i].duration() > last) last = g.routes[i].duration(), latest = k;
  }
  if (last < g.best_arrival) {
    g.best_arrival = last;
    g.best = g.routes;
  }
  if (latest == 0 || g.best_arrival < good_enough * soonest) return false;  // no robot arrives if all have given up
  const auto tries = std::min(most_improvements, 60 / static_cast<int>(g.order.size()));
  if (g.improvements++ >= tries || scene.t > g.began + 0.7 * g.lead) return false;
  std::rotate(g.order.begin(), g.order.begin() + static_cast<std::ptrdiff_t>(latest),
              g.order.begin() + static_cast<std::ptrdiff_t>(latest + 1));
  std::fill(g.planned.begin(), g.planned.end(), std::uint8_t{0});
  g.next = 0;
  return true;
}

void Planner::end_group(const Scene& scene) noexcept {
  Group& g = group_;
  // Routes begin when they were planned to, or now, if planning took longer.
  const double late = std::max(0.0, scene.t - g.began - g.lead);
  const double due = g.began + late;
  for (const std::size_t i : g.order) {
    robots_[i].route = g.best[i];
    robots_[i].keeps = keep_;
    robots_[i].joins = 0.0;
    if (g.give_way && distance(g.best[i].end(), goal(i, scene)) < at_place) robots_[i].makes_room = false;
    // A member that is still braking is taken from where it will stand.
    set_off(i, due);
    robots_[i].gives_way = g.give_way;
  }
  for (const std::size_t i : g.order)
    for (const std::size_t j : g.order) shift_[i * robots_.size() + j] = 0.0;
  g.active = false;
  improvement_.failures = 0;
}

void Planner::plan(const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal) noexcept {
  if (group_.active) return go_on_with_group(scene, nominal);
  bool group = false, everybody = false, somebody_drives = false;
  for (std::size_t i = 0; i < robots_.size(); ++i)
    somebody_drives =
        somebody_drives || (robots_[i].state == State::driving && !robots_[i].needs_plan && !stands(i, scene));
  // Who has given way sets off only when all have: it might bar the others' way out again.
  const bool somebody_gives_way = std::any_of(robots_.begin(), robots_.end(), [](const Robot& robot) {
    return robot.gives_way && robot.makes_room && robot.state == State::driving && !robot.stood;
  });
  const std::array<std::size_t, Merging::most> before = merging_.robots;
  merging_.count = 0;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    if (!robot.needs_plan || stands(i, scene)) continue;
    const bool due =
        scene.t >= robot.retry && !(somebody_gives_way && robot.gives_way && robot.state == State::waiting);
    if (!rests(i, scene)) {
      if (due && merging_.count < Merging::most) merging_.robots[merging_.count++] = i;
    } else {
      group = group || due;
      // While others drive there may soon be a way that there was not: they are not stopped for it. One that waits for
      // its next attempt counts as well: a group takes it along, and its attempt is over then.
      everybody = everybody || robot.all_anew || (robot.no_way && !somebody_drives);
    }
  }
  if (merging_.robots != before) merging_.searched = 0;
  if (merging_.count > 0) plan_merges(scene, gains, nominal);
  for (std::size_t i = 0; i < robots_.size() && setup_.improve && spent_ == 0 && !group; ++i) {
    const Robot& robot = robots_[i];
    const bool on_its_way = robot.state == State::driving && !rests(i, scene) && robot.rate > 0.999;
    if (on_its_way && !stands(i, scene) && scene.t >= robot.looks_at) look_again(i, scene, gains, nominal);
  }
  if (!group) {
    if (setup_.improve && spent_ == 0)
      improve_on_the_way(scene, nominal);
    else
      improvement_.asked = 0;
    return;
  }
  improvement_.asked = 0;
  begin_group(scene, nominal, everybody);
  go_on_with_group(scene, nominal);
}

}  // namespace skein::core
