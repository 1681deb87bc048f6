#include "core/planning/planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double route_comfort = 0.012;     // routes keep so much more than the shield asks for: it does not act where
                                            // two pass one another on straight lines [m]
constexpr double arrived = 1e-3;            // [m]
constexpr double longest_way = 300.0;       // [s]
constexpr double route_end_angle = 0.03;    // [rad]
constexpr double held_back = 0.10;          // by the shield, from a place that moves: a new plan [m]
constexpr double too_late = 0.4;            // [s]
constexpr double put_off = 0.015;           // by the shield, on the last piece of a way [m]
constexpr double again_after = 1.0;         // at least [s]
constexpr double pushed_off_place = 0.008;  // from a place at rest [m]
constexpr double release = 0.1;             // of couplings [s]
constexpr double ramp = 0.3;                // of couplings that come back [s]
constexpr double rate_slope = 2.0;          // of a clock [1/s]
constexpr double unseen = 0.02;             // who is so little behind does not count [s]
constexpr double error_free = 0.010;        // behind its route: clocks run on; at `error_stop` they stand [m]
constexpr double error_stop = 0.025;        // [m]
constexpr double between_walls = 0.02;      // no more room than this, beyond what must be [m]
constexpr double turns_within = 0.0005;     // of where its route turns there; at twice as much its clock stands [m]
constexpr double sets_off_within = 0.005;   // of the heading in which it drives on there [rad]
constexpr double looks_every = 5;           // ticks
constexpr double keeps_route = 1.0;         // a robot on a route that is not seen for less long does [s]
constexpr double stays_after = 3.0;         // a robot that stands so long is taken to stay there [s]
constexpr double formation_slope = 0.25;    // of its clock, times the largest v_ref [m/s^2]
constexpr double stuck_for = 4.0;           // a clock that has hardly run for this long: a new plan for all robots [s]
constexpr double margin_after = 1.0;        // of doubt that lasts; the first time, `margin_first` [s]
constexpr double margin_first = 0.2;        // [s]
constexpr double margin_shuts = 2.0;        // who has no way with a margin is given one without [s]
constexpr double margin_steps = 1e4;        // [1/m]
constexpr double margin_excess = 0.0005;    // more than is needed: it is reduced [m]
constexpr double most_margin = 0.005;       // [m]
constexpr double barred_for = 1.0;          // from its route, by an obstacle: a new plan for that robot alone [s]
constexpr double beside_obstacle = 0.005;   // so much room at most, beyond what must be [m]

bool is_at(const Pose& place, const Pose& pose) noexcept {
  return distance(pose, place) < arrived && std::abs(wrap_angle(pose.theta - place.theta)) < route_end_angle;
}

/// How much smaller than the largest bodies are, each size once.
std::vector<double> sizes_of(const Planner::Setup& setup) {
  std::vector<double> sizes = setup.smaller;
  if (sizes.empty()) sizes.push_back(0.0);
  std::sort(sizes.begin(), sizes.end());
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  return sizes;
}

std::vector<Lattice> make_lattices(const Planner::Setup& setup) {
  std::vector<Lattice> lattices;
  for (const double smaller : sizes_of(setup))
    lattices.emplace_back(setup.arena, setup.shield_distance - setup.radius - smaller + 0.0005, setup.obstacles);
  return lattices;
}

const Lattice& finest(const std::vector<Lattice>& lattices) {
  return *std::max_element(lattices.begin(), lattices.end(),
                           [](const Lattice& a, const Lattice& b) { return a.size() < b.size(); });
}

}  // namespace

Planner::Planner(const Setup& setup, const Reference& reference, FormationClock* clock)
    : reference_(&reference),
      clock_(clock),
      setup_(setup),
      lattices_(make_lattices(setup)),
      lattice_of_(setup.robots),
      traffic_(setup.robots),
      expected_(setup.robots),
      search_(finest(lattices_), setup.robots),
      paces_(setup.robots),
      robots_(setup.robots),
      goals_(setup.robots),
      rest_from_(setup.robots, never),
      coupled_(setup.robots),
      on_route_(setup.robots),
      shift_(setup.robots * setup.robots) {
  constexpr double sampled = 0.1;  // [s]
  const std::vector<double> sizes = sizes_of(setup);
  for (std::size_t i = 0; i < setup.smaller.size(); ++i)
    lattice_of_[i] = static_cast<std::size_t>(std::find(sizes.begin(), sizes.end(), setup.smaller[i]) - sizes.begin());
  // Beyond the end as well: a robot may be on its way to a place at rest when time is over.
  const double end = setup.duration + longest_way;
  for (std::size_t i = 0; i < setup.robots; ++i) {
    goals_[i] = reference.at(i, end).pose;
    for (double t = end; t >= 0.0 && reference.at(i, t).twist == Twist{}; t -= sampled) rest_from_[i] = t;
  }
  obstacles_.reserve(setup.obstacles);
  group_.order.reserve(setup.robots);
  group_.member.resize(setup.robots);
  group_.planned.resize(setup.robots);
  group_.from.resize(setup.robots);
  group_.stands.resize(setup.robots);
  group_.places.resize(setup.robots);
  group_.routes.resize(setup.robots);
  group_.best.resize(setup.robots);
  improvement_.role.resize(setup.robots);
  improvement_.from.resize(setup.robots);
  improvement_.routes.resize(setup.robots);
  merging_.yields.resize(setup.robots);
  for (auto& last : merging_.last_yields) last.resize(setup.robots);
  merging_.order.resize(setup.robots);
  merging_.comes.resize(setup.robots);
  reset();
}

void Planner::go_on_from(const Planner& other) {
  const Reference* const reference = reference_;
  FormationClock* const clock = clock_;
  *this = other;
  reference_ = reference;
  clock_ = clock;
  search_.look_at(lattice(group_.asking            ? group_.order[group_.next]
                          : improvement_.searching ? improvement_.next
                                                   : 0),
                  traffic_);
}

double Planner::time_left(std::size_t i) const noexcept {
  const Robot& robot = robots_[i];
  if (robot.state != State::driving || robot.makes_room) return std::numeric_limits<double>::quiet_NaN();
  return (robot.joins > 0.0 ? robot.joins : robot.route.duration()) - robot.clock;
}

void Planner::reset() noexcept {
  for (Robot& robot : robots_) robot = Robot{}, robot.waits_for = robot.taken_by = robots_.size();
  std::fill(shift_.begin(), shift_.end(), 0.0);
  group_.active = false;
  improvement_.asked = improvement_.failures = 0;
  improvement_.draw.seed(0U);
  improvement_.searching = false;
  merging_.searched = 0;
  begun_ = false;
  if (clock_ != nullptr) clock_->reset();
}

bool Planner::rests(std::size_t i, const Scene& scene) const noexcept {
  if (scene.to_starts) return true;
  return rest_from_[i] < never && (!coupled_[i] || formation_t_ >= rest_from_[i]);
}

/// Whether robot i is out of sight for a moment only, on a route: it keeps the route, and its clock stands meanwhile.
/// Planning it anew from rest would hold up robots whose routes pass there, and those behind them.
bool Planner::pauses(std::size_t i, const Scene& scene) const noexcept {
  const Robot& robot = robots_[i];
  return out_of_sight(i, scene) && robot.state == State::driving && rests(i, scene) && robot.unseen_for < keeps_route;
}

Pose Planner::goal(std::size_t i, const Scene& scene) const noexcept {
  return scene.to_starts ? reference_->at(i, 0.0).pose : goals_[i];
}

/// Whether an obstacle, or a robot that stands without a plan, is where robot i is to rest.
bool Planner::is_taken(std::size_t i, const Scene& scene) noexcept {
  const Pose to = goal(i, scene);
  std::size_t& by = robots_[i].taken_by;
  by = robots_.size();
  if (const Lattice::Place in = lattice(i).inside(to.x, to.y); !lattice(i).free(in.x, in.y)) return true;
  for (std::size_t j = 0; j < robots_.size(); ++j)
    if (j != i && stands(j, scene) && distance(scene.poses[j], to) < least_apart() - closer(i, j)) by = j;
  return by != robots_.size();
}

/// Whether robot i is at the place where it rests, so that it needs no way there.
bool Planner::is_back(std::size_t i, const Scene& scene, const Pose& place) const noexcept {
  const bool over = scene.to_starts || (rests(i, scene) && formation_t_ >= rest_from_[i]);
  return over && distance(scene.poses[i], place) <= pushed_off_place + 2.0 * scene.doubt &&
         std::abs(wrap_angle(scene.poses[i].theta - place.theta)) <= looks_elsewhere;
}

/// Whether robot i, as it drives now, comes upon a robot that stands, or an obstacle: soon, or anywhere on its way to
/// rest.
void Planner::watch(std::size_t i, const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal,
                    bool to_the_end) noexcept {
  Robot& robot = robots_[i];
  if (lattice(i).has_obstacles() && pass_obstacle(i, scene, gains, nominal)) return;
  const bool follows = robot.state == State::nominal && nominal[i].twist != Twist{};
  if (!follows && robot.state != State::driving) return;
  constexpr double step = 0.2;
  Pose before = scene.poses[i];
  double ahead = 0.0, until = sees_ahead;
  if (to_the_end && rests(i, scene))
    until = std::max(until, follows ? rest_from_[i] - formation_t_ : robot.route.duration() - robot.clock);
  while ((ahead += step) < until) {
    const Pose there = follows ? reference_->at(i, scene.t + ahead).pose : robot.route.at(robot.clock + ahead).pose;
    bool meets = false;
    if (const Lattice::Place in = lattice(i).inside(there.x, there.y);
        !lattice(i).free(in.x, in.y) || !lattice(i).free({before.x, before.y}, {before.x, before.y}))
      meets = !lattice(i).free(in.x, in.y) && lattice(i).free(before.x, before.y);
    for (std::size_t j = 0; j < robots_.size() && !meets; ++j) {
      if (j == i) continue;
      const bool stays = stands(j, scene) || (robots_[j].state == State::waiting && robots_[j].no_way);
      const bool drives_by = ahead < sees_ahead && follows && !stays && robots_[j].state == State::nominal && j < i &&
                             nominal[j].twist != Twist{};
      if (!stays && !drives_by) continue;
      const Pose other = stays ? scene.poses[j] : reference_->at(j, scene.t + ahead).pose;
      const double d = distance(there, other), keep = setup_.shield_distance - closer(i, j) + 0.008;
      meets = d < keep && d < distance(before, stays ? other : scene.poses[j]) - 1e-3;
    }
    if (meets) {
      robot.needs_plan = true;
      return;
    }
    before = there;
  }
}

/// Whether a robot that was to be there before robot i has not passed yet.
bool Planner::must_wait(std::size_t i, double ahead) noexcept {
  Robot& robot = robots_[i];
  const std::size_t n = robots_.size();
  const double fastest = 2.0 * std::max(fastest_pace_, 0.1);  // no route is so fast [m/s]
  robot.waits_for = n;
  const double at = robot.clock + ahead, planned = robot.due + at;
  const Route::Position there = robot.route.position(at);
  const Pose here = on_route_[i];
  const auto from_there = [&](const Route::Position& p) { return math::hypot(p.x - there.x, p.y - there.y); };
  constexpr double less = 0.004, step = 0.1;
  constexpr double nearing = 0.005;  // of two that are nearer already, at most [m/s]
  for (std::size_t j = 0; j < n; ++j) {
    const Robot& other = robots_[j];
    if (j == i || other.state != State::driving || other.stood) continue;
    const double theirs = other.due + shift_[i * n + j];  // of its clock 0, in this robot's schedule
    const double until = std::min(planned - theirs, other.route.duration());
    // On routes to places that drive on, robots drive closely behind one another: a clock that runs is assumed to run
    // on.
    const double runs = robot.joins > 0.0 && other.joins > 0.0 ? ahead * other.rate : 0.0, runs_to = other.clock + runs;
    if (runs_to >= until - unseen) continue;
    const Pose now = on_route_[j];
    const double most = std::min(robot.keeps, other.keeps) - closer(i, j) - less;
    // Too far away to get there by then.
    const double reach = most + fastest * (until + step - other.clock);
    if (const double x = now.x - there.x, y = now.y - there.y; x * x + y * y > reach * reach) continue;
    // Between the lattice's points routes come a few millimetres nearer to each other. Of two clocks that waited for
    // more than the routes keep, each would wait for the other.
    const double planned_apart = from_there(other.route.position(until));
    const double keep = std::min(
        {most, distance(now, here) - nearing * ahead, std::max(planned_apart, least_apart() - closer(i, j)) - 1e-6});
    for (double t = runs_to; t < until + step;) {
      const double apart = from_there(other.route.position(std::min(t, until)));
      if (apart < keep) {
        robot.waits_for = j;
        return true;
      }
      const double comes = t + (apart - keep) / fastest - 1e-6;  // not before
      do t += step;
      while (t < comes);
    }
  }
  return false;
}

/// How fast the clock of robot i may run: so that it can stop before the first moment ahead at which it must wait. One
/// that stands looks ahead no farther than others may be behind it unseen: of two that looked farther, each would stand
/// for the other. On its way to a place that drives on a robot stops early: it is replanned where it is late.
double Planner::may_run(std::size_t i, const Scene& scene) noexcept {
  if (!rests(i, scene)) return must_wait(i, 0.2) || must_wait(i, 0.4) ? 0.0 : 1.0;
  double free = 0.0;
  for (const double ahead : {unseen, 0.1, 0.2, 0.4}) {
    if (must_wait(i, ahead)) return std::sqrt(2.0 * rate_slope * free);
    free = ahead;
  }
  return 1.0;
}

void Planner::run_clock(std::size_t i, const Scene& scene, double dt) noexcept {
  Robot& robot = robots_[i];
  const Pose here = on_route_[i];
  const double error = distance(here, scene.poses[i]);
  // Where its route turns on the spot, a robot does not come nearer to it by waiting.
  const bool drives = robot.route.twist(robot.clock, dt).v != 0.0;
  double wanted = drives ? std::clamp((error_stop - error) / (error_stop - error_free), 0.0, 1.0) : 1.0;
  wanted = std::min(wanted, may_run(i, scene));
  robot.rate += std::clamp(wanted - robot.rate, -rate_slope * dt, rate_slope * dt);
  // Between walls it turns only where its route turns, and sets off only when it has turned. Otherwise it drives on
  // beside its route, and the shield stops it for good at the inside of a bend.
  if (lattice(i).room(here.x, here.y) < between_walls) {
    const Pose& pose = scene.poses[i];
    const Twist last = robot.route.twist(robot.clock - dt, dt), next = robot.route.twist(robot.clock, dt);
    const auto [sin, cos] = math::sincos(pose.theta);
    const double ahead = cos * (here.x - pose.x) + sin * (here.y - pose.y);
    const auto stop = [&](double off, double free) {
      robot.rate = std::min(robot.rate, std::clamp(2.0 - std::abs(off) / free, 0.0, 1.0));
    };
    if (next.v == 0.0 && next.omega != 0.0) stop(ahead, turns_within + 2.0 * scene.doubt);
    if (next.v != 0.0 && last.v == 0.0)
      stop(wrap_angle(here.theta - pose.theta), sets_off_within + 2.0 * scene.doubt / standard_radius);
  }
  if (pauses(i, scene)) robot.rate = 0.0;
  const bool hardly_runs = robot.rate < 0.3;
  robot.held_for = hardly_runs ? robot.held_for + dt : 0.0;
  // A clock that stands for its own robot, and for no other: an obstacle that bars it from its route does not go away.
  // In a passage that is too narrow for uncertain poses, no other route is better.
  const bool is_barred = hardly_runs && !margin_.given_up && drives && error > error_free &&
                         robot.waits_for == robots_.size() && !pauses(i, scene) &&
                         lattice(i).room(scene.poses[i].x, scene.poses[i].y) < beside_obstacle;
  robot.barred = is_barred ? robot.barred + dt : 0.0;
  const State before = robot.state;
  const double step = robot.rate * dt;
  const Twist twist = robot.route.twist(robot.clock, std::max(step, 1e-9));
  robot.reference = {here, {twist.v * robot.rate, twist.omega * robot.rate}};
  robot.clock += step;
  robot.state = before;
  on_route_[i] = robot.route.at(robot.clock).pose;
}

/// Slows the formation's clock while a robot is on its way back to a place that moves, and lets it hurry afterwards.
void Planner::let_formation_wait(const Scene& scene, const Gains& gains) noexcept {
  if (!(demand_.v > 0.0)) demand_ = reference_->demand(gains.k_y);
  if (!(demand_.v > 0.0)) return;
  bool away = false;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Robot& robot = robots_[i];
    if (stands(i, scene) || std::isnan(scene.poses[i].x) || rests(i, scene)) continue;
    away = away || robot.needs_plan || (robot.state != State::nominal && robot.state != State::passing);
  }
  clock_->step(now_, away, scene.hurry, formation_slope / demand_.v);
}

/// The formation's reference, on the clock of those that yield.
void Planner::follow_yielding(std::size_t i, double t) noexcept {
  const double rate = yield_.rate(t);
  robots_[i].reference = reference_->at(i, t - yield_.at(t));
  Twist& twist = robots_[i].reference.twist;
  twist = {rate * twist.v, rate * twist.omega};
}

/// How fast each robot drives along a route.
void Planner::know_paces(const Gains& gains) noexcept {
  fastest_pace_ = 0.0;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    paces_[i].v = std::min(0.98 * free_v(gains, i), 0.9 * free_omega(gains, i) / gains.k_y);
    paces_[i].omega = 0.85 * free_omega(gains, i);
    fastest_pace_ = std::max(fastest_pace_, paces_[i].v);
  }
}

/// The shield keeps a robot whose pose is uncertain farther from obstacles: on a route that did not, it would stop for
/// good. A margin that followed each frame that is missing would change routes all the time. Returns whether the margin
/// has changed.
bool Planner::follow_doubt(double doubt, double dt) noexcept {
  Margin& m = margin_;
  if (!m.known && doubt == 0.0) return false;
  // A passage so narrow lets a robot through as long as the camera is lucky, and slowly: better than none.
  const bool is_shut = std::any_of(robots_.begin(), robots_.end(), [](const Robot& robot) { return robot.no_way; });
  m.shuts = is_shut && m.kept > 0.0 ? m.shuts + dt : 0.0;
  if (m.shuts > margin_shuts) {
    m.given_up = true;
    m.shuts = m.kept = 0.0;
    return true;
  }
  if (m.given_up) return false;
  m.least = std::min(m.least, doubt);
  m.most = std::max(m.most, doubt);
  m.lasts += dt;
  if (m.lasts < (m.known ? margin_after : margin_first)) return false;
  m.known = true;
  double wanted = m.kept;
  if (m.least > m.kept)
    wanted = m.least;
  else if (m.most < m.kept - margin_excess)
    wanted = m.most;
  wanted = std::min(most_margin, std::ceil(margin_steps * wanted - 1e-9) / margin_steps);
  m.least = never, m.most = m.lasts = 0.0;
  return std::exchange(m.kept, wanted) != wanted;
}

void Planner::step(const Scene& scene, const Gains& gains, double dt, std::span<const ReferencePoint> nominal,
                   std::span<ReferencePoint> reference) noexcept {
  const std::size_t n = robots_.size();
  now_ = scene.t;
  formation_t_ = clock_ == nullptr ? now_ : now_ - clock_->behind(now_);
  spent_ = 0;
  ++tick_;
  keep_ = setup_.shield_distance + route_comfort + 2.0 * scene.doubt;
  know_paces(gains);
  const bool is_new = !std::equal(obstacles_.begin(), obstacles_.end(), scene.obstacles.begin(), scene.obstacles.end());
  if (is_new) margin_.given_up = false;
  const bool changed = follow_doubt(scene.doubt, dt) || is_new;
  if (changed) {
    obstacles_.assign(scene.obstacles.begin(), scene.obstacles.end());
    for (Lattice& each : lattices_) each.build(scene.obstacles, margin_.kept);
    for (Robot& robot : robots_) robot.retry = robot.patience = 0.0;
  }
  for (std::size_t i = 0; i < n; ++i)
    if (robots_[i].state == State::nominal) {
      coupled_[i] = gains.k_xx.row_sum(i) + gains.k_tt.row_sum(i) + gains.k_yy.row_sum(i) > 0.0;
      robots_[i].reference = nominal[i];
    } else if (robots_[i].state == State::yielding) {
      follow_yielding(i, scene.t);
      if (scene.t >= yield_.ends()) robots_[i].state = State::nominal;
    } else if (robots_[i].state == State::passing) {
      robots_[i].reference = robots_[i].aside.shift(*reference_, i, scene.t);
      if (scene.t >= robots_[i].aside.ends()) robots_[i].state = State::nominal, robots_[i].reference = nominal[i];
    }
  const bool begins = !begun_ || to_starts_ != scene.to_starts;
  for (std::size_t i = 0; i < n; ++i)
    robots_[i].is_new = !std::isnan(scene.poses[i].x) && (begins || std::isnan(robots_[i].before.x));
  find_conflicts(scene, nominal);
  begun_ = true;
  to_starts_ = scene.to_starts;

  // Of a new obstacle, and of a robot that will not go on soon, everybody is told whose way it bars, however far ahead.
  bool barred = changed && !begins;
  for (std::size_t i = 0; i < n; ++i) {
    Robot& robot = robots_[i];
    robot.unseen_for = out_of_sight(i, scene) ? robot.unseen_for + dt : 0.0;
    const double before = std::exchange(robot.stood_for, stands(i, scene) ? robot.stood_for + dt : 0.0);
    barred = barred || (before < stays_after && robot.stood_for >= stays_after);
  }
  for (Robot& robot : robots_) robot.looks_far = robot.looks_far || barred;

  for (std::size_t i = 0; i < n; ++i) {
    Robot& robot = robots_[i];
    const Pose& pose = scene.poses[i];
    if (std::isnan(pose.x)) continue;
    if (pauses(i, scene)) continue;  // its clock stands
    if (scene.out[i]) {
      if (robot.state != State::waiting) robot.route.stand(pose);
      robot.state = State::waiting;
    }
    if (stands(i, scene)) {  // the reference of one that is stuck goes on to tell it where to drive
      robot.stood = true;
      robot.needs_plan = false;
      continue;
    }
    if (robot.stood) {
      robot.stood = false;
      robot.retry = robot.patience = 0.0;
      // A way of a millimetre, which noise alone makes, would turn it round on the spot.
      robot.needs_plan = !is_back(i, scene, nominal[i].pose);
      if (!robot.needs_plan) robot.state = State::nominal, robot.reference = nominal[i];
    }
    const double away = distance(pose, robot.reference.pose);
    if (robot.state == State::nominal || robot.state == State::passing) {
      const bool at_rest = nominal[i].twist == Twist{};
      if (std::abs(wrap_angle(pose.theta - robot.reference.pose.theta)) > looks_elsewhere && rests(i, scene) &&
          (formation_t_ < rest_from_[i] || scene.to_starts))
        robot.needs_plan = true;
      // A hand moves a robot within a tick. One that the shield has held up comes back by the law alone, unless that is
      // far: a plan begins with a stop, which would hold up those behind it.
      const bool by_hand = distance(pose, robot.before) > put_elsewhere;
      const double far = at_rest && rests(i, scene) ? pushed_off_place : by_hand ? put_elsewhere : held_back;
      if (away > far + 2.0 * scene.doubt) robot.needs_plan = true;
    } else if (away > 2.0 * put_elsewhere + 2.0 * scene.doubt) {
      robot.needs_plan = true;
      // The law would drive it straight back to where it waited, through whatever is in between.
      if (robot.state == State::waiting) wait_here(i, pose);
    }
    // A way to a moving place is planned for a time: a robot that is late for it would meet others there.
    const bool late = robot.state == State::driving && !rests(i, scene) && lag(i) > too_late;
    if ((late || (robot.state == State::returning && away > put_off + 2.0 * scene.doubt)) &&
        scene.t > robot.due + again_after)
      robot.needs_plan = true;
    if ((tick_ + i) % static_cast<std::size_t>(looks_every) == 0 || changed || robot.looks_far) {
      watch(i, scene, gains, nominal, robot.looks_far);
      if (robot.state != State::waiting) robot.looks_far = false;
    }
    if (robot.state == State::driving && !group_.active && (robot.held_for > stuck_for || robot.barred > barred_for)) {
      robot.needs_plan = true;
      robot.all_anew = robot.held_for > stuck_for && rests(i, scene);
      robot.held_for = robot.barred = 0.0;
    }
  }
  for (std::size_t i = 0; i < n; ++i) robots_[i].before = scene.poses[i];
  if (clock_ != nullptr && !scene.to_starts) let_formation_wait(scene, gains);
  plan(scene, gains, nominal);

  for (std::size_t i = 0; i < n; ++i)
    if (robots_[i].state == State::driving) on_route_[i] = robots_[i].route.at(robots_[i].clock).pose;
  for (std::size_t i = 0; i < n; ++i) {
    Robot& robot = robots_[i];
    switch (robot.state) {
      case State::nominal:
        robot.reference = nominal[i];
        break;
      case State::waiting: {  // brakes along its route, and stands at its end
        const Twist twist = robot.route.twist(robot.clock, dt);
        robot.reference = {robot.route.at(robot.clock).pose, twist};
        robot.clock += dt;
        break;
      }
      case State::yielding:
        follow_yielding(i, scene.t);
        break;
      case State::passing:
        robot.reference = robot.aside.shift(*reference_, i, scene.t);
        break;
      case State::driving:
        if (!rests(i, scene) && robot.clock >= robot.joins) {  // it is where its place is, or nearly
          robot.reference = {robot.route.at(robot.clock).pose, nominal[i].twist};
          robot.state = State::returning;
          if (is_at(nominal[i].pose, robot.reference.pose)) robot.state = State::nominal, robot.reference = nominal[i];
          break;
        }
        run_clock(i, scene, dt);
        if (robot.clock >= robot.route.duration() && robot.makes_room) {
          wait_for_a_way(i);
        } else if (robot.clock >= robot.route.duration()) {
          robot.state = rests(i, scene) ? State::nominal : State::returning;
          robot.reference.pose = robot.route.end();
          if (robot.state == State::nominal && formation_t_ < rest_from_[i] && !scene.to_starts) {
            // Sooner at its place than the file asks: it stays.
            robot.state = State::driving;
          } else if (robot.state == State::nominal) {
            robot.reference = nominal[i];
          }
        }
        break;
      case State::returning: {
        robot.reference.pose = advance(robot.reference.pose, robot.reference.twist, dt);
        const ReferenceBounds bounds = reference_bounds(gains, i);
        robot.reference.twist = homing(nominal[i], robot.reference, bounds, dt);
        if (is_at(nominal[i].pose, robot.reference.pose)) {
          robot.state = State::nominal;
          robot.reference = nominal[i];
        }
        break;
      }
    }
    const double wanted = robot.state == State::nominal && !scene.out[i] ? 1.0 : 0.0;
    robot.share += std::clamp(wanted - robot.share, -dt / release, dt / ramp);
    reference[i] = robot.reference;
  }
}

}  // namespace skein::core
