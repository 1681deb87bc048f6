#include "core/planning/route.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double no_angle = 1e-6;  // [rad]
constexpr double no_way = 1e-6;    // [m]

}  // namespace

double Pace::turn_time(double angle) const noexcept {
  return std::abs(angle) < no_angle ? 0.0 : Travel(std::abs(angle), omega, alpha).duration();
}

double Pace::drive_time(double distance) const noexcept {
  return distance < no_way ? 0.0 : Travel(distance, v, acceleration).duration();
}

double Pace::start_time() const noexcept {
  return SmoothStep::steepest * v / acceleration;
}

void Route::stand(const Pose& pose) noexcept {
  size_ = 0;
  start_ = pose;
}

Pose Route::stop(const Pose& pose, double v, const Pace& pace) noexcept {
  const double way = 0.5 * v * std::abs(v) / pace.acceleration;
  const auto [sin, cos] = math::sincos(pose.theta);
  return {pose.x + way * cos, pose.y + way * sin, pose.theta};
}

double Route::stop_time(double v, const Pace& pace) noexcept {
  return std::abs(v) / pace.acceleration;
}

void Route::brake(const Pose& pose, double v, const Pace& pace) noexcept {
  stand(pose);
  Segment segment;
  segment.kind = Segment::Kind::roll;
  segment.duration = stop_time(v, pace);
  segment.from.pose = pose;
  segment.amount = 0.5 * v * segment.duration;
  segment.v = v;
  add(segment);
}

void Route::stop_at(double t, const Pace& pace) noexcept {
  while (size_ > 0 && segments_[size_ - 1].t >= t) --size_;
  if (size_ == 0) return;
  Segment& last = segments_[size_ - 1];
  if (last.amount == 0.0) last.duration = std::min(last.duration, t - last.t);  // it waits
  // A drive that was cut off before ends at full speed if its braking began at this very time and is left out.
  const double until = std::min(t - last.t, last.duration);
  if (last.kind != Segment::Kind::drive || until >= last.travel.duration() || size_ == segments_.size()) return;
  last.duration = until;
  Segment brakes;
  brakes.kind = Segment::Kind::roll;
  brakes.t = last.t + until;
  brakes.from = at(last, last.duration);
  brakes.v = last.travel.at(last.duration).v;
  brakes.duration = stop_time(brakes.v, pace);
  brakes.amount = 0.5 * brakes.v * brakes.duration;
  add(brakes);
}

bool Route::turn(double angle, const Pace& pace) noexcept {
  if (std::abs(angle) < no_angle) return true;
  if (size_ == segments_.size()) return false;
  Segment segment;
  segment.kind = Segment::Kind::turn;
  segment.t = duration();
  segment.from = at(segment.t);
  segment.amount = angle;
  segment.travel = Travel(std::abs(angle), pace.omega, pace.alpha);
  segment.duration = segment.travel.duration();
  add(segment);
  return true;
}

bool Route::roll(double length, double curvature, double v_0, double v_1) noexcept {
  if (length < 1e-9) return true;
  if (size_ == segments_.size()) return false;
  Segment segment;
  segment.kind = Segment::Kind::roll;
  segment.t = duration();
  segment.from = at(segment.t);
  segment.amount = length;
  segment.curvature = curvature;
  segment.v = v_0;
  segment.duration = 2.0 * length / (v_0 + v_1);
  add(segment);
  return true;
}

bool Route::wait(double seconds) noexcept {
  if (!(seconds > 0.0)) return true;
  if (size_ == segments_.size()) return false;
  Segment segment;
  segment.kind = Segment::Kind::roll;
  segment.t = duration();
  segment.from = at(segment.t);
  segment.duration = seconds;
  add(segment);
  return true;
}

void Route::add(const Segment& segment) noexcept {
  Segment& added = segments_[size_++] = segment;
  if (added.kind == Segment::Kind::turn || added.curvature != 0.0) return;
  const auto [sin, cos] = math::sincos(added.from.pose.theta);
  added.cos = cos, added.sin = sin;
}

bool Route::append(std::span<const Leg> legs, double heading, const Pace& pace) noexcept {
  if (size_ + 2 * legs.size() + 1 > segments_.size()) return false;
  State at_end = at(duration());
  double t = duration();
  const auto turn = [&](double to) {
    const double angle = wrap_angle(to - at_end.pose.theta);
    if (std::abs(angle) < no_angle) return;
    Segment segment;
    segment.kind = Segment::Kind::turn;
    segment.t = t;
    segment.from = at_end;
    segment.amount = angle;
    segment.travel = Travel(std::abs(angle), pace.omega, pace.alpha);
    segment.duration = segment.travel.duration();
    add(segment);
    t += segment.duration;
    at_end = at(segment, segment.duration);
  };
  for (const Leg& leg : legs) {
    const double dx = leg.x - at_end.pose.x, dy = leg.y - at_end.pose.y, way = math::hypot(dx, dy);
    if (way < no_way) continue;
    turn(math::atan2(dy, dx));
    Segment segment;
    segment.kind = Segment::Kind::drive;
    segment.t = std::max(t, leg.drives_at);
    segment.from = at_end;
    segment.amount = way;
    const double shortest = pace.drive_time(way), planned = leg.arrives_at - segment.t;
    segment.travel =
        planned > shortest ? Travel::within(way, planned, pace.acceleration) : Travel(way, pace.v, pace.acceleration);
    segment.duration = segment.travel.duration();
    add(segment);
    t = segment.t + segment.duration;
    at_end = at(segment, segment.duration);
    at_end.pose.x = leg.x, at_end.pose.y = leg.y;
  }
  turn(heading);
  return true;
}

/// How far a roll has come: its speed changes evenly, so that the mean of both ends' makes the whole way. [m]
double Route::rolled(const Segment& segment, double t) noexcept {
  const double share = segment.duration > 0.0 ? t / segment.duration : 1.0;
  return segment.v * segment.duration * share + (segment.amount - segment.v * segment.duration) * share * share;
}

Route::State Route::at(const Segment& segment, double t) noexcept {
  State state = segment.from;
  switch (segment.kind) {
    case Segment::Kind::turn: {
      const double turned = std::copysign(segment.travel.at(t).s, segment.amount);
      state.turned += turned;
      state.pose.theta = wrap_angle(state.pose.theta + turned);
      return state;
    }
    case Segment::Kind::drive: {
      const double way = segment.travel.at(t).s;
      state.driven += way;
      state.pose.x += way * segment.cos;
      state.pose.y += way * segment.sin;
      return state;
    }
    case Segment::Kind::roll: {
      const double way = rolled(segment, t);
      state.driven += way;
      if (segment.curvature == 0.0) {
        state.pose = {state.pose.x + way * segment.cos, state.pose.y + way * segment.sin, wrap_angle(state.pose.theta)};
        return state;
      }
      state.turned += segment.curvature * way;
      state.pose = advance(state.pose, {way, segment.curvature * way}, 1.0);
      return state;
    }
  }
  return state;
}

Route::Position Route::position(const Segment& segment, double t) noexcept {
  const Pose& from = segment.from.pose;
  switch (segment.kind) {
    case Segment::Kind::turn:
      return {from.x, from.y};
    case Segment::Kind::drive: {
      const double way = segment.travel.at(t).s;
      return {from.x + way * segment.cos, from.y + way * segment.sin};
    }
    case Segment::Kind::roll:
      break;
  }
  const Pose pose = at(segment, t).pose;
  return {pose.x, pose.y};
}

/// The last one that has begun.
std::size_t Route::segment_at(double t) const noexcept {
  std::size_t low = 0, high = size_;
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (segments_[middle].t <= t ? low : high) = middle;
  }
  return low;
}

Route::State Route::at(double t) const noexcept {
  if (size_ == 0) return {start_, 0.0, 0.0};
  const Segment& segment = segments_[segment_at(t)];
  return at(segment, std::clamp(t - segment.t, 0.0, segment.duration));
}

Route::Position Route::position(double t) const noexcept {
  std::size_t segment = size_ == 0 ? 0 : segment_at(t);
  return position(t, segment);
}

Route::Position Route::position(double t, std::size_t& segment) const noexcept {
  if (size_ == 0) return {start_.x, start_.y};
  while (segment + 1 < size_ && segments_[segment + 1].t <= t) ++segment;
  const Segment& in = segments_[segment];
  return position(in, std::clamp(t - in.t, 0.0, in.duration));
}

Twist Route::twist(double t, double dt) const noexcept {
  if (!(dt > 0.0)) return {};  // no time has passed yet in the first tick
  const State now = at(t), then = at(t + dt);
  return {(then.driven - now.driven) / dt, (then.turned - now.turned) / dt};
}

}  // namespace skein::core
