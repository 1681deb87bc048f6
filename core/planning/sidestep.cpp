#include "core/planning/sidestep.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double farthest = 0.35;      // beside its place [m]
constexpr double height_step = 0.004;  // between two that are tried [m]
constexpr double height_more = 0.044;  // than the place needs, at most [m]
constexpr double spare = 0.003;        // more room than must be kept: the shield slows a robot that has less [m]
constexpr double rounding = 1e-4;      // [m]
constexpr double lead = 0.25;          // along the lane, to be 0.1 m beside it [m]
constexpr double shortest = 1.0;       // of a rise [s]
constexpr double longest = 8.0;        // of a lead [s]
/// A mean heading of the place, and the share of its place's speed that a robot drives along the lane at least. On the
/// inside of a corner those who follow one another come nearer: the shorter the mean, the more.
struct Manner {
  std::size_t apart;  // of the mean's moments [samples]
  double along;
};
constexpr std::array<Manner, 4> manners{Manner{1, 0.7}, Manner{4, 0.7}, Manner{8, 0.66}, Manner{1, 0.3}};
constexpr double most_change = 0.35;  // of its speed [m/s^2]
constexpr double settles = 1.0;       // so long its place is free behind what it has passed [s]
constexpr std::size_t most_together = 3;
constexpr std::array<double, 3> shares{0.0, 0.5, 1.0};          // share of the time that the place is in an obstacle
constexpr std::array<double, 4> returns{1.0, 0.75, 0.55, 1.4};  // of the usual lead

double share_of(double t, double of) noexcept {
  return of > 0.0 ? std::clamp(t / of, 0.0, 1.0) : 1.0;
}

constexpr int mean_of = 4;         // steps to both sides
constexpr double mean_step = 0.1;  // the shortest [s]
constexpr std::size_t farthest_mean = 8 * mean_of;

/// A place, and the mean of its headings and turning rates around that moment.
struct Place {
  Pose pose;
  Twist twist;
  double heading, turning;  // [rad], [rad/s]
};

ReferencePoint late(const Reference& reference, std::size_t i, double t, const Delay& delay) noexcept {
  if (t >= delay.ends()) return reference.at(i, t);
  ReferencePoint point = reference.at(i, t - delay.at(t));
  const double rate = delay.rate(t);
  point.twist = {rate * point.twist.v, rate * point.twist.omega};
  return point;
}

Place place_at(const Reference& reference, std::size_t i, double t, const Delay& delay, double apart) noexcept {
  const ReferencePoint now = late(reference, i, t, delay);
  double off = 0.0, turning = now.twist.omega;
  for (int k = 1; k <= mean_of; ++k)
    for (const double sign : {-1.0, 1.0}) {
      const ReferencePoint at = late(reference, i, t + sign * apart * k, delay);
      off += wrap_angle(at.pose.theta - now.pose.theta);
      turning += at.twist.omega;
    }
  constexpr double of = 2.0 * mean_of + 1.0;
  return {now.pose, now.twist, now.pose.theta + off / of, turning / of};
}

/// What is so far beside a place, with the heading of its motion.
struct Moving {
  Pose pose;
  double speed;  // [m/s]
  double along;  // the lane [m/s]
};

Moving beside(const Pose& place, const Twist& twist, double heading, double turning,
              const Sidestep::Aside& aside) noexcept {
  const double c = math::cos(heading), s = math::sin(heading), by_turning = -aside.by * turning;
  const double v_x = twist.v * math::cos(place.theta) + by_turning * c - aside.rate * s;
  const double v_y = twist.v * math::sin(place.theta) + by_turning * s + aside.rate * c;
  return {{place.x - aside.by * s, place.y + aside.by * c, math::atan2(v_y, v_x)},
          math::hypot(v_x, v_y),
          v_x * c + v_y * s};
}

}  // namespace

Sidestep::Sidestep(double t, const Aside& from, const Profile& profile, const Delay& delay, double mean) noexcept
    : begins_(t), profile_(profile), mean_step_(mean), delay_(delay) {
  const double c_2 = 0.5 * from.bend, r = profile.rises;
  const double way = profile.height - from.by - from.rate * r - c_2 * r * r, rate = -from.rate - 2.0 * c_2 * r,
               bend = -2.0 * c_2;
  rise_ = {from.by,
           from.rate,
           c_2,
           (10.0 * way - 4.0 * rate * r + 0.5 * bend * r * r) / (r * r * r),
           (-15.0 * way + 7.0 * rate * r - bend * r * r) / (r * r * r * r),
           (6.0 * way - 3.0 * rate * r + 0.5 * bend * r * r) / (r * r * r * r * r)};
}

double Sidestep::ends() const noexcept {
  return std::max(begins_ + profile_.rises + profile_.stays + profile_.falls, delay_.ends());
}

Sidestep::Aside Sidestep::at(double t) const noexcept {
  const double since = t - begins_;
  if (since >= profile_.rises + profile_.stays + profile_.falls) return {};
  if (since < profile_.rises) {
    const double w = std::max(0.0, since);
    const auto& c = rise_;
    return {c[0] + w * (c[1] + w * (c[2] + w * (c[3] + w * (c[4] + w * c[5])))),
            c[1] + w * (2.0 * c[2] + w * (3.0 * c[3] + w * (4.0 * c[4] + w * 5.0 * c[5]))),
            2.0 * c[2] + w * (6.0 * c[3] + w * (12.0 * c[4] + w * 20.0 * c[5]))};
  }
  if (since < profile_.rises + profile_.stays) return {profile_.height, 0.0, 0.0};
  const double w = share_of(since - profile_.rises - profile_.stays, profile_.falls), left = 1.0 - w;
  return {profile_.height * left * left * left * (1.0 + 3.0 * w + 6.0 * w * w),
          -30.0 * profile_.height * w * w * left * left / profile_.falls,
          -60.0 * profile_.height * w * left * (1.0 - 2.0 * w) / (profile_.falls * profile_.falls)};
}

Pose Sidestep::pose(const Reference& reference, std::size_t i, double t) const noexcept {
  const Place place = place_at(reference, i, t, delay_, mean_step_);
  return beside(place.pose, place.twist, place.heading, place.turning, at(t)).pose;
}

ReferencePoint Sidestep::shift(const Reference& reference, std::size_t i, double t) const noexcept {
  constexpr double soon = 0.02;  // [s]
  const Place place = place_at(reference, i, t, delay_, mean_step_);
  const Moving now = beside(place.pose, place.twist, place.heading, place.turning, at(t));
  return {now.pose, {now.speed, wrap_angle(pose(reference, i, t + soon).theta - now.pose.theta) / soon}};
}

/// The samples whose place is in the first obstacles that come, `together_` of them; false: there are not so many.
bool SidestepSearch::find_obstacles() noexcept {
  const auto blocked = [&](std::size_t k) { return places_[k].blocked; };
  constexpr auto end = static_cast<std::size_t>(looks_ahead / step);
  first_ = 0;
  while (first_ < end && !blocked(first_)) ++first_;
  if (first_ == end) return false;
  last_ = first_;
  for (std::size_t count = 1;; ++count) {
    while (last_ + 1 < samples && blocked(last_ + 1)) ++last_;
    if (count == together_) break;
    std::size_t behind = last_ + 1;
    while (behind < end + 60 && !blocked(behind)) ++behind;
    if (behind >= end + 60) return false;
    last_ = behind;
  }
  needed_ = {0.0, 0.0};
  for (std::size_t s = 0; s < 2; ++s)
    for (std::size_t k = first_; k <= last_; ++k) needed_[s] = std::max(needed_[s], needs(s == 0 ? 1.0 : -1.0, k));
  height_ = least_ = std::min(needed_[0], needed_[1]);
  highest_ =
      height_ < farthest
          ? std::max(needed_[0] < farthest ? needed_[0] : 0.0, needed_[1] < farthest ? needed_[1] : 0.0) + height_more
          : 0.0;
  side_ = 0;
  shape_ = 0;
  return true;
}

/// How far beside the place there is room, at that sample. [m]
double SidestepSearch::needs(double side, std::size_t k) noexcept {
  const At& at = places_[k];
  const double n_x = -side * math::sin(at.heading), n_y = side * math::cos(at.heading);
  double by = 0.0;
  while (by < farthest) {
    const double room = lattice_->room(at.pose.x + by * n_x, at.pose.y + by * n_y);
    ++samples_;
    if (room >= spare) return by;
    by += std::max(0.5 * height_step, spare - room > 0.05 ? 0.01 : 0.0);
  }
  return 1e9;
}

/// How long before it is so far beside its place a robot leaves the lane. [s]
double SidestepSearch::leads(double height) const noexcept {
  const double v = std::max(1e-3, places_[first_].twist.v);
  return std::min(longest, lead * std::sqrt(std::max(0.02, height) / 0.1) / v);
}

SidestepSearch::Lane SidestepSearch::begin(const Query& query, const Reference& reference,
                                           const Lattice& lattice) noexcept {
  query_ = query;
  reference_ = &reference;
  lattice_ = &lattice;
  samples_ = 0;
  constexpr auto far = static_cast<std::size_t>(looks_ahead / step);
  if (!sample(0, far)) return Lane::free;
  sample(far, samples);
  manner_ = 0;
  if (!begin_again()) return Lane::free;
  const double middle = 0.5 * step * static_cast<double>(first_ + last_);
  const bool on_lane = query.from.by == 0.0 && query.from.rate == 0.0 && query.from.bend == 0.0;
  return on_lane && height_ < farthest && middle > leads(height_) + 0.5 ? Lane::later : Lane::blocked;
}

/// Where the place will be; whether it meets an obstacle. Only the place may lie beyond the edge, never the robot.
bool SidestepSearch::sample(std::size_t from, std::size_t to) noexcept {
  bool blocked = false;
  for (std::size_t k = from; k < to; ++k) {
    const ReferencePoint at = late(*reference_, query_.robot, query_.t + step * static_cast<double>(k), query_.delay);
    const Lattice::Place in = lattice_->inside(at.pose.x, at.pose.y);
    places_[k] = {at.pose, at.twist, at.pose.theta, at.twist.omega, lattice_->room(in.x, in.y) < -rounding};
    blocked = blocked || places_[k].blocked;
  }
  samples_ += to - from;
  return blocked;
}

void SidestepSearch::take_means() noexcept {
  static_assert(step == mean_step);
  const std::size_t apart = manners[manner_].apart;
  std::array<ReferencePoint, farthest_mean> before{};  // of now
  for (std::size_t k = 1; k <= mean_of * apart; ++k)
    before[k - 1] = late(*reference_, query_.robot, query_.t - step * static_cast<double>(k), query_.delay);
  for (std::size_t k = 0; k + farthest_mean < samples; ++k) {
    At& at = places_[k];
    double off = 0.0, turning = at.twist.omega;
    for (std::size_t d = apart; d <= mean_of * apart; d += apart) {
      const At& later = places_[k + d];
      const Pose& pose = k >= d ? places_[k - d].pose : before[d - k - 1].pose;
      off += wrap_angle(later.pose.theta - at.pose.theta) + wrap_angle(pose.theta - at.pose.theta);
      turning += later.twist.omega + (k >= d ? places_[k - d].twist.omega : before[d - k - 1].twist.omega);
    }
    constexpr double of = 2.0 * mean_of + 1.0;
    at.heading = at.pose.theta + off / of;
    at.turning = turning / of;
  }
}

bool SidestepSearch::next_shape() noexcept {
  if (++shape_ < shapes) return true;
  shape_ = 0;
  if (++side_ < 2) return true;
  side_ = 0;
  // Finely at first, then coarsely; and for each side just what it needs.
  double higher = height_ + (height_ < least_ + 2.5 * height_step ? height_step : 3.0 * height_step);
  for (const double needed : needed_)
    if (needed > height_ + 1e-9 && needed < higher) higher = needed;
  height_ = higher;
  if (height_ <= highest_) return true;
  if (++together_ <= most_together && find_obstacles()) return true;
  return ++manner_ < manners.size() && begin_again();
}

bool SidestepSearch::begin_again() noexcept {
  take_means();
  together_ = 1;
  return find_obstacles();
}

bool SidestepSearch::next(Sidestep& way) noexcept {
  if (together_ > most_together) return false;
  do {
    if (work() >= query_.most_work) break;
    if (height_ > highest_ || height_ < needed_[side_]) continue;
    const double middle = 0.5 * step * static_cast<double>(first_ + last_);
    const double half = 0.5 * step * static_cast<double>(last_ - first_) * shares[shape_ % shares.size()];
    const double rises = std::max(shortest, middle - half),
                 falls_for = returns[shape_ / shares.size()] * leads(height_);
    const Sidestep::Profile profile{side_ == 0 ? height_ : -height_, rises, std::max(0.0, middle + half - rises),
                                    falls_for};
    way = Sidestep(query_.t, query_.from, profile, query_.delay, step * static_cast<double>(manners[manner_].apart));
    if (!fits(way)) continue;
    if (!next_shape()) together_ = most_together + 1;
    return true;
  } while (next_shape());
  together_ = most_together + 1;
  return false;
}

/// Whether it stays inside the bounds, and clear of obstacles and edges.
bool SidestepSearch::fits(const Sidestep& way) noexcept {
  const auto last = static_cast<std::size_t>((way.ends() + settles - query_.t) / step) + 1;
  if (last + farthest_mean >= samples) return false;
  const double shrinks = math::exp(-0.95 * query_.gamma * step);
  double room = 0.0;
  Moving before{};
  for (std::size_t k = 0; k <= last; ++k) {
    ++samples_;
    const At& at = places_[k];
    const Moving now =
        beside(at.pose, at.twist, at.heading, at.turning, way.at(query_.t + step * static_cast<double>(k)));
    if (now.along < manners[manner_].along * at.twist.v || now.speed > query_.pace.v) return false;
    const double here = lattice_->room(now.pose.x, now.pose.y);
    if (k > 0) {
      const double omega = wrap_angle(now.pose.theta - before.pose.theta) / step;
      if (std::abs(omega) + query_.k_y * std::max(now.speed, before.speed) > query_.pace.omega) return false;
      if (std::abs(now.speed - before.speed) > most_change * step) return false;
      if (here < (room > 0.0 ? shrinks * room : room) - rounding) return false;
    }
    room = here;
    before = now;
  }
  return true;
}

bool SidestepSearch::clear(const Sidestep& way, std::size_t robot, double t, const Reference& reference,
                           const Lattice& lattice) noexcept {
  const auto left = static_cast<std::size_t>(std::max(0.0, (way.ends() - t) / step)) + 1;
  for (std::size_t k = 0; k < left; k += 2) {
    const Pose at = way.pose(reference, robot, t + step * static_cast<double>(k));
    if (lattice.room(at.x, at.y) < -1e-3) return false;
  }
  return true;
}

}  // namespace skein::core
