#include "core/avoidance/steering.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double ride_step = 0.2;         // of a trial ride [s]
constexpr double turn_rate = 4.0;         // how fast a heading error is turned away, before the bounds [1/s]
constexpr double comfort = 0.02;          // more than must be kept is better, up to this much [m]
constexpr double nearer = 1e-3;           // a meeting that brings two no nearer than this is none [m]
constexpr double soon_share = 0.1;        // share of a step
constexpr double length_rounding = 1e-6;  // [m]
constexpr double end_rate = 2.0;          // how fast a way ends [1/s]
constexpr int directions = 24;

// What a course costs, against 1 for the way that top speed makes within the horizon. Waiting must cost more than going
// round, or a crowd in which all robots wait for one another never moves.
constexpr double aside = 0.10;           // straight back, less for smaller angles
constexpr double to_the_left = 0.06;     // makes robots pass on the right
constexpr double meeting = 0.1;          // another robot, within the horizon
constexpr double meeting_long = 1.5;     // all the way; a part for a part of it
constexpr double discomfort = 0.2;       // passing as near as may be
constexpr double turning_round = 0.15;   // from the last course to the opposite one
constexpr double other_way_round = 0.2;  // a long turn, against the one that it is in
constexpr double waiting = 0.3;          // standing; half of it at half speed

}  // namespace

double ReferenceBounds::v_limit(double omega_ref) const noexcept {
  return std::max(0.0, std::min(v, (omega - std::abs(omega_ref)) / k_y));
}

ReferenceBounds reference_bounds(const Gains& gains, std::size_t i) noexcept {
  return {std::max(0.0, free_v(gains, i) - gains.k_xx.row_sum(i)),
          std::max(0.0, free_omega(gains, i) - gains.k_tt.row_sum(i) - gains.k_yy.row_sum(i)), gains.k_y};
}

Steering::Steering(std::size_t robots, std::size_t obstacles) {
  movers_.reserve(robots + obstacles);
}

Twist Steering::towards(double heading, double speed, double theta, const ReferenceBounds& bounds) noexcept {
  const double off = wrap_angle(heading - theta);
  const double omega = std::clamp(turn_rate * off, -bounds.omega_limit(), bounds.omega_limit());
  return {std::min(speed * std::max(0.0, math::cos(off)), bounds.v_limit(omega)), omega};
}

/// All robots within reach, and the distance to keep from each: from one that is nearer already, its present distance.
void Steering::gather_movers(const Scene& scene, std::size_t i, std::span<const std::uint32_t> near, double x, double y,
                             double reach) noexcept {
  movers_.clear();
  const auto add = [&](double at_x, double at_y, double v_x, double v_y, double keep) {
    const double d = math::hypot(at_x - x, at_y - y);
    if (d < reach + keep) movers_.push_back({at_x, at_y, v_x, v_y, std::min(keep, d - length_rounding)});
  };
  for (const std::uint32_t j : near) {
    if (j == i) continue;
    const Pose& p = scene.poses[j];
    const double v = scene.twists[j].v;
    const auto [sin, cos] = math::sincos(p.theta);
    add(p.x, p.y, v * cos, v * sin, scene.keep + scene.sizes.beyond(i, j));
  }
  for (const Obstacle& o : scene.obstacles)
    add(o.x, o.y, 0.0, 0.0, scene.keep - standard_radius + o.radius + scene.sizes.beyond(i));
}

/// What is left over between (x, y) at time t and the nearest of the others, beyond what is to be kept. [m]
double Steering::gap(double x, double y, double t) const noexcept {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Mover& m : movers_) {
    const double dx = x - m.x - m.v_x * t, dy = y - m.y - m.v_y * t;
    const double within = m.keep + comfort;
    const double squared = dx * dx + dy * dy;
    if (squared < within * within) smallest = std::min(smallest, std::sqrt(squared) - m.keep);
  }
  return smallest;
}

Steering::Ride Steering::ride(const Scene& scene, const Query& query, double heading, double speed) const noexcept {
  const ReferencePoint& goal = query.goal;
  const auto outside = [&](double x, double y) {
    return std::max(std::abs(x) - scene.half_width, std::abs(y) - scene.half_height) + scene.sizes.beyond(query.robot);
  };
  const double allowed_outside = std::max(0.0, outside(query.from.x, query.from.y)) + nearer;
  const double v_x = goal.twist.v * math::cos(goal.pose.theta), v_y = goal.twist.v * math::sin(goal.pose.theta);
  Pose pose = query.from;
  Ride result{0.0, 0.0, std::numeric_limits<double>::infinity()};
  int steps = 0, held = 0;
  double t = ride_step;
  for (; t < query.horizon + 0.5 * ride_step; ++steps) {
    const Twist twist = towards(heading, speed, pose.theta, query.bounds);
    const double off = wrap_angle(heading - pose.theta);
    pose.theta =
        std::abs(off) < std::abs(twist.omega) * ride_step ? heading : wrap_angle(pose.theta + twist.omega * ride_step);
    const auto [sin, cos] = math::sincos(pose.theta);
    const double x = pose.x + twist.v * ride_step * cos, y = pose.y + twist.v * ride_step * sin;
    double left_over = gap(x, y, t);
    // The shield asks at every moment: a chord may not begin with coming nearer either.
    if (left_over < comfort)
      left_over = std::min(left_over, gap(pose.x + soon_share * (x - pose.x), pose.y + soon_share * (y - pose.y),
                                          t - ride_step + soon_share * ride_step));
    result.closest = std::min(result.closest, left_over);
    if (left_over < 0.0 || outside(x, y) > allowed_outside)
      ++held;  // as the shield holds it: it stands, and goes on turning
    else
      pose.x = x, pose.y = y;
    result.off += math::hypot(goal.pose.x + v_x * t - pose.x, goal.pose.y + v_y * t - pose.y);
    t += ride_step;
  }
  result.off /= steps;
  result.held = static_cast<double>(held) / steps;
  return result;
}

Course Steering::choose(const Scene& scene, const Query& query) noexcept {
  const Pose& from = query.from;
  const ReferencePoint& goal = query.goal;
  const ReferenceBounds& bounds = query.bounds;
  const double horizon = query.horizon, waited = query.waited;
  gather_movers(scene, query.robot, query.near, from.x, from.y, 2.0 * bounds.v * horizon);
  const double left = math::hypot(goal.pose.x - from.x, goal.pose.y - from.y);
  // Where the goal will be by the time that the robot can be there.
  const double fastest = std::max(bounds.v, 1e-3);
  const double lead = goal.twist.v * std::min(horizon, left / fastest);
  const double dx = goal.pose.x + lead * math::cos(goal.pose.theta) - from.x;
  const double dy = goal.pose.y + lead * math::sin(goal.pose.theta) - from.y;
  const double straight = math::hypot(dx, dy) > 1e-6 ? math::atan2(dy, dx) : goal.pose.theta;
  const double top = std::min(bounds.v, std::abs(goal.twist.v) + end_rate * left);

  Course best;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double off, double speed, bool along) {
    const double heading = along ? goal.pose.theta : wrap_angle(straight + off);
    const Ride r = ride(scene, query, heading, speed);
    double cost = (r.off - left) / (0.5 * fastest * horizon) / (1.0 + waited);
    cost += aside * std::abs(off) / pi + (off > 0.0 ? to_the_left : 0.0);
    if (r.held > 0.0) cost += meeting + meeting_long * r.held;
    if (r.closest < comfort) cost += discomfort * (1.0 - std::max(0.0, r.closest) / comfort);
    if (!std::isnan(query.last_heading))
      cost += turning_round * std::abs(wrap_angle(heading - query.last_heading)) / pi;
    // A long turn, once begun, goes on the same way round.
    if (const double turn = wrap_angle(heading - from.theta);
        std::abs(turn) > 0.5 * pi && turn * query.last_omega < 0.0)
      cost += other_way_round;
    cost += waiting * (1.0 + waited) * (1.0 - speed / fastest);
    if (cost < least) {
      least = cost;
      best = {heading, speed, off == 0.0 && !along && r.held == 0.0 && speed == top, r.held == 0.0};
    }
  };
  for (int k = 0; k <= directions / 2; ++k)
    for (const int side : {-1, 1}) {
      if (side > 0 && (k == 0 || k == directions / 2)) continue;
      const double off = side * 2.0 * pi * k / directions;
      consider(off, top, false);
      consider(off, 0.5 * top, false);
    }
  consider(0.0, 0.0, false);
  // One that is ahead of a goal that moves waits for it, and looks the goal's way.
  if (goal.twist.v > 0.0)
    for (const double share : {1.0, 0.5, 0.0}) consider(0.0, share * std::min(top, goal.twist.v), true);
  return best;
}

bool Steering::conflict(const Scene& scene, std::size_t i, std::span<const std::uint32_t> near,
                        const ReferencePoint& reference, double horizon) noexcept {
  const Pose& here = scene.poses[i];
  const Pose from{here.x, here.y, reference.pose.theta};
  double t = ride_step;
  while (t < horizon + 0.5 * ride_step) {
    const Pose there = advance(from, reference.twist, t);
    const auto meets = [&](const Pose& now, const Pose& then, double keep) {
      const double d = distance(there, then);
      return d < keep && d < distance(here, now) - nearer;
    };
    for (const std::uint32_t j : near)
      if (meets(scene.poses[j], advance(scene.poses[j], scene.twists[j], t), scene.keep + scene.sizes.beyond(i, j)))
        return true;
    for (const Obstacle& o : scene.obstacles)
      if (meets({o.x, o.y, 0.0}, {o.x, o.y, 0.0}, scene.keep - standard_radius + o.radius + scene.sizes.beyond(i)))
        return true;
    t += ride_step;
  }
  return false;
}

}  // namespace skein::core
