#include "core/planning/merge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/control/tracking_error.h"
#include "core/kinematics/unicycle.h"

namespace skein::core {
namespace {

constexpr double forever = std::numeric_limits<double>::infinity();
constexpr double there = 0.004;        // [m]
constexpr double looks_there = 0.1;    // [rad]
constexpr double longest_home = 15.0;  // [s]
constexpr double look_ahead = 40.0;    // [s]
constexpr double time_step = 0.25;     // [s]
constexpr double acceleration = 0.55;  // [m/s^2]
constexpr double sight = 0.06;         // how far ahead a reference looks that comes home [m]
constexpr double turn_gain = 4.0;      // [1/s]
constexpr double soon = 5.0;           // no need to look for a better way [s]
constexpr double catch_up = 2.0;       // [1/s]

}  // namespace

Twist homing(const ReferencePoint& place, const ReferencePoint& from, const ReferenceBounds& bounds,
             double dt) noexcept {
  const double c = std::cos(place.pose.theta), s = std::sin(place.pose.theta);
  const double dx = from.pose.x - place.pose.x, dy = from.pose.y - place.pose.y;
  const double ahead = c * dx + s * dy, aside = c * dy - s * dx, off = wrap_angle(from.pose.theta - place.pose.theta);
  // Towards a point of the place's line, nearer the nearer it is to that line.
  const double wanted_off = -std::atan2(aside, sight);
  const double omega_limit = bounds.omega_limit();
  const double omega =
      std::clamp(place.twist.omega + turn_gain * wrap_angle(wanted_off - off), -omega_limit, omega_limit);
  const double along = std::max(std::cos(off), 0.3);
  const double wanted = std::clamp((place.twist.v - catch_up * ahead) / along, 0.0, bounds.v_limit(omega));
  const double most = acceleration * dt;
  return {std::min(std::clamp(wanted, from.twist.v - most, from.twist.v + most),
                   std::max(bounds.v_limit(omega), from.twist.v - most)),
          omega};
}

bool Merge::clear(double x, double y, double t) const noexcept {
  const double at = std::clamp(t / Traffic::step, 0.0, static_cast<double>(Traffic::steps - 1));
  const auto k = static_cast<std::size_t>(at);
  const std::size_t next = std::min(k + 1, Traffic::steps - 1);
  const double share = at - static_cast<double>(k);
  for (std::size_t j = 0; j < traffic_->robots(); ++j) {
    const double r = radius_[j];
    if (r <= 0.0) continue;
    const double o_x = traffic_->x(j, k), o_y = traffic_->y(j, k);
    const double dx = o_x + share * (traffic_->x(j, next) - o_x) - x,
                 dy = o_y + share * (traffic_->y(j, next) - o_y) - y;
    if (dx * dx + dy * dy < r * r) return false;
  }
  return true;
}

bool Merge::clear_line(const Lattice::Place& from, const Lattice::Place& to, double leaves,
                       double arrives) const noexcept {
  const auto samples = static_cast<int>(std::ceil((arrives - leaves) / (1.5 * Traffic::step))) + 1;
  for (int k = 0; k <= samples; ++k) {
    const double share = static_cast<double>(k) / samples;
    if (!clear(from.x + share * (to.x - from.x), from.y + share * (to.y - from.y), leaves + share * (arrives - leaves)))
      return false;
  }
  return true;
}

/// When a robot that homes in from there, standing, is at its place; infinity: not before `most`, or not without
/// meeting somebody.
double Merge::home(Pose from, double t, double most) noexcept {
  ++trials_;
  constexpr double dt = 0.1;
  ReferencePoint point{from, {}};
  for (const double begun = t; t < most && t < begun + longest_home; t += dt) {
    const ReferencePoint place = reference_->at(query_.robot, query_.t + t);
    if (distance(place.pose, point.pose) < there &&
        std::abs(wrap_angle(place.pose.theta - point.pose.theta)) < looks_there)
      return t;
    point.twist = homing(place, point, query_.bounds, dt);
    point.pose = advance(point.pose, point.twist, dt);
    if (!clear(point.pose.x, point.pose.y, t + dt) || !lattice_->free(point.pose.x, point.pose.y)) return forever;
  }
  return forever;
}

void Merge::try_point(const Stand& stand, const Leg* before, double back, double aside, double wait,
                      Way& best) noexcept {
  const Pace& pace = query_.pace;
  const double sets_off = stand.t + wait;
  for (double t = sets_off; t < std::min(sets_off + look_ahead, best.done); t += time_step) {
    const Pose place = reference_->at(query_.robot, query_.t + t).pose;
    const double c = std::cos(place.theta), s = std::sin(place.theta);
    const Lattice::Place to{place.x - back * c - aside * s, place.y - back * s + aside * c};
    const double dx = to.x - stand.pose.x, dy = to.y - stand.pose.y, way = std::hypot(dx, dy);
    if (way > pace.v * (t - sets_off)) continue;
    const double heading = way > 1e-3 ? std::atan2(dy, dx) : stand.pose.theta;
    const double leaves = sets_off + pace.turn_time(wrap_angle(heading - stand.pose.theta));
    const double arrives = leaves + (way > 1e-3 ? pace.drive_time(way) : 0.0);
    if (arrives > t) continue;
    const Lattice::Place from{stand.pose.x, stand.pose.y};
    if (way > 1e-3 && !lattice_->free(from, to)) return;
    if (!clear_line(from, from, stand.t, leaves) || !clear_line(from, to, leaves, arrives)) return;
    const double done = home({to.x, to.y, heading}, arrives, best.done);
    if (done >= best.done) return;
    best.done = done;
    best.found = true;
    best.heading = heading;
    best.count = 0;
    if (before) best.legs[best.count++] = *before;
    if (way > 1e-3) best.legs[best.count++] = {to.x, to.y, leaves, arrives};
    return;
  }
}

void Merge::try_from(const Stand& stand, const Leg* before, Way& best) noexcept {
  if (const double done = home(stand.pose, stand.t, best.done); done < best.done) {
    best.done = done;
    best.found = true;
    best.heading = stand.pose.theta;
    best.count = 0;
    if (before) best.legs[best.count++] = *before;
  }
  if (before) {
    for (const double back : {0.0, 0.05})
      for (const double aside : {0.0, 0.1, -0.1}) try_point(stand, before, back, aside, 0.0, best);
    return;
  }
  for (const double wait : {0.0, 0.7, 1.5, 3.0, 5.0})
    for (const double back : {0.0, 0.03, 0.08})
      for (const double aside : {0.0, 0.03, -0.03, 0.1, -0.1}) try_point(stand, before, back, aside, wait, best);
}

Merge::Way Merge::find(const Query& query, const Reference& reference, const Lattice& lattice,
                       const Traffic& traffic) noexcept {
  query_ = query;
  reference_ = &reference;
  lattice_ = &lattice;
  traffic_ = &traffic;
  trials_ = 0;
  const auto k0 = std::min(Traffic::steps - 1, static_cast<std::size_t>(query.begins / Traffic::step));
  for (std::size_t j = 0; j < traffic.robots(); ++j) {
    radius_[j] = 0.0;
    if (j == query.robot || !traffic.present(j)) continue;
    // Who comes near while the robot still stands and turns is held up by the shield for a moment.
    const auto k1 = std::min(Traffic::steps - 1, k0 + static_cast<std::size_t>(query.grace / Traffic::step));
    double d = query.keep + 1.0;
    for (std::size_t k = k0; k <= k1; ++k)
      d = std::min(d, std::hypot(traffic.x(j, k) - query.from.x, traffic.y(j, k) - query.from.y));
    radius_[j] = std::min(query.keep, std::max(d - 1e-3, 0.0));
  }
  Way best;
  best.done = query.begins + look_ahead + longest_home;
  try_from({query.from, query.begins}, nullptr, best);
  if (best.found && best.done - query.begins < soon) return best;
  // Round somebody or something: by a point of a ring.
  constexpr int directions = 12;
  const Lattice::Place from{query.from.x, query.from.y};
  for (const double radius : {0.12, 0.25, 0.45}) {
    for (int k = 0; k < directions; ++k) {
      const double heading = 2.0 * pi * k / directions;
      const Lattice::Place to{from.x + radius * std::cos(heading), from.y + radius * std::sin(heading)};
      if (!lattice.free(to.x, to.y) || !lattice.free(from, to)) continue;
      const double leaves = query.begins + query.pace.turn_time(wrap_angle(heading - query.from.theta));
      const double arrives = leaves + query.pace.drive_time(radius);
      if (!clear_line(from, from, query.begins, leaves) || !clear_line(from, to, leaves, arrives)) continue;
      const Leg leg{to.x, to.y, leaves, arrives};
      try_from({{to.x, to.y, heading}, arrives}, &leg, best);
    }
  }
  return best;
}

}  // namespace skein::core
