#include "core/planning/merge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/control/tracking_error.h"
#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double acceleration = 0.55;  // [m/s^2]
constexpr double sight = 0.06;         // how far ahead a reference looks that comes home [m]
constexpr double turn_gain = 4.0;      // [1/s]
constexpr double catch_up = 2.0;       // [1/s]

constexpr double drives = 0.005;            // a slower robot stands [m/s]
constexpr double slow_arc = 0.55;           // of the top speed: a tight arc is driven so fast
constexpr double goes_straight = 0.12;      // who drives goes on as it does while its couplings are released [s]
constexpr double merge_rounding = 1e-4;     // [m]
constexpr double rounding_of_times = 1e-6;  // [s]
constexpr double reach = 0.06;              // beyond what is to be kept no robot closes in too fast [m]
constexpr std::size_t coarse = 8;           // samples
constexpr std::array<double, 2> lane{0.11, -0.11};                                      // beside the place [m]
constexpr std::array<double, 6> past_obstacles{0.05, -0.05, 0.11, -0.11, 0.18, -0.18};  // beside the place [m]
constexpr std::array<double, 3> lane_back{0.06, 0.0, -0.05};                            // [m]
constexpr std::array<double, 3> entries{1.0, 2.5, 4.0};  // of a lane, where the place is so much after it was near [s]
constexpr double look_back = 12.0;                       // so long ago it may have been [s]
constexpr double same_curvature = 0.05;                  // [1/m]
constexpr std::array<double, 4> waits{0.0, 0.7, 1.5, 3.0};  // before a way by another point [s]
// One that is blocked is tried again so much later. [s]
constexpr std::array<double, 8> later{0.5, 0.5, 1.0, 1.0, 2.0, 3.0, 4.0, 8.0};
constexpr std::array<double, 2> radii{0.13, 0.3};  // of the rings round the robot that a way round goes by [m]

double turned_to(double sign, double angle) noexcept {  // in [0, 2 pi)
  const double a = std::remainder(sign * angle, 2.0 * pi);
  return a < -1e-9 ? a + 2.0 * pi : std::max(a, 0.0);
}

}  // namespace

Twist homing(const ReferencePoint& place, const ReferencePoint& from, const ReferenceBounds& bounds,
             double dt) noexcept {
  const auto [s, c] = math::sincos(place.pose.theta);
  const double dx = from.pose.x - place.pose.x, dy = from.pose.y - place.pose.y;
  const double ahead = c * dx + s * dy, aside = c * dy - s * dx, off = wrap_angle(from.pose.theta - place.pose.theta);
  // Towards a point of the place's line, nearer the nearer it is to that line.
  const double wanted_off = -math::atan2(aside, sight);
  const double omega_limit = bounds.omega_limit();
  const double omega =
      std::clamp(place.twist.omega + turn_gain * wrap_angle(wanted_off - off), -omega_limit, omega_limit);
  const double along = std::max(math::cos(off), 0.3);
  const double wanted = std::clamp((place.twist.v - catch_up * ahead) / along, 0.0, bounds.v_limit(omega));
  const double most = acceleration * dt;
  return {std::min(std::clamp(wanted, from.twist.v - most, from.twist.v + most),
                   std::max(bounds.v_limit(omega), from.twist.v - most)),
          omega};
}

Merge::Merge() {
  trials_.reserve(most_starts * kinds);
}

/// Its place so long after the traffic's beginning.
ReferencePoint Merge::place(double t) const noexcept {
  const double at = query_.t + t;
  ReferencePoint point = reference_->at(query_.robot, at - query_.delay.at(at));
  const double rate = query_.delay.rate(at);
  point.twist = {rate * point.twist.v, rate * point.twist.omega};
  return point;
}

/// At which times its place is in an obstacle, or about to drive into one: who joined it then would have to leave it at
/// once. If that is so for a long time, less of a free stretch must do.
void Merge::find_ways_into_obstacles() noexcept {
  constexpr double patience = 20.0, least = 0.5;  // [s]
  leads_into_obstacle_.fill(0);
  lane_blocked_ = false;
  if (!lattice_->has_obstacles() || query_.stays_free <= 0.0) return;
  const double longest = std::min(query_.stays_free, look_ahead - time_step);
  const auto last = times + static_cast<std::size_t>(longest / time_step) + 1;
  for (std::size_t k = 0; k <= last; ++k) {
    const Pose at = place(time_step * static_cast<double>(k)).pose;
    const Lattice::Place in = lattice_->inside(at.x, at.y);
    free_at_[k] = lattice_->free(in.x, in.y) ? 1 : 0;
  }
  constexpr std::size_t never_yet = 2 * times;
  double stretch = 2.0 * longest;
  while ((stretch *= 0.5) > least) {
    const auto steps = static_cast<std::size_t>(stretch / time_step) + 1;
    std::size_t entry = never_yet, soonest = never_yet;  // the next, of the times that follow
    bool free_then = free_at_[times + steps] != 0;
    for (std::size_t k = times + steps; k-- > 0;) {
      const bool free_now = free_at_[k] != 0;
      if (free_now && !free_then) entry = k + 1;
      free_then = free_now;
      if (k >= times) continue;
      leads_into_obstacle_[k] = !free_now || entry <= k + steps ? 1 : 0;
      if (leads_into_obstacle_[k] == 0)
        soonest = k;
      else
        lane_blocked_ = true;
    }
    samples_ += times + steps;
    if (static_cast<double>(soonest) * time_step >= patience) continue;
    const auto blocked = std::find(leads_into_obstacle_.begin(), leads_into_obstacle_.end(), 1);
    const auto behind = std::find(blocked, leads_into_obstacle_.end(), 0);
    lane_free_from_ = time_step * static_cast<double>(behind - leads_into_obstacle_.begin());
    return;
  }
  leads_into_obstacle_.fill(0);
  lane_blocked_ = false;
}

/// Where its place is at a sample of the traffic.
Route::Position Merge::place_at_sample(std::size_t k) noexcept {
  if (knows_place_[k] == 0) {
    const Pose at = place(Traffic::step * static_cast<double>(k)).pose;
    place_[k] = {at.x, at.y};
    knows_place_[k] = 1;
  }
  return place_[k];
}

/// The curve from the end of a start to the place. The bend of its beginning and of its end are in `kind`: on the spot,
/// or an arc. False: there is none, or it cannot be there until `latest`.
bool Merge::plan(const Start& start, std::size_t kind, const ReferencePoint& to, double latest,
                 Course& course) noexcept {
  ++courses_;
  const double first = curvatures_[kind / bends], last = curvatures_[kind % bends];
  const double a = query_.pace.acceleration, v_1 = std::max(0.0, to.twist.v);
  Pose end = to.pose;
  if (last == 0.0) {  // it turns on the spot a little behind, and runs up
    const double way = 0.5 * v_1 * v_1 / a, turn = v_1 > drives ? to.twist.omega / v_1 : 0.0;
    end = advance(end, {-way, -turn * way}, 1.0);
  }
  const double r_1 = first == 0.0 ? 0.0 : 1.0 / first, r_2 = last == 0.0 ? 0.0 : 1.0 / last;
  const auto from = math::sincos(start.at.theta), into = math::sincos(end.theta);
  const double dx = end.x - r_2 * into.sin - start.at.x + r_1 * from.sin;
  const double dy = end.y + r_2 * into.cos - start.at.y - r_1 * from.cos;
  const double h = r_2 - r_1, squared = dx * dx + dy * dy - h * h;
  if (squared < 0.0) return false;
  const double straight = std::sqrt(squared);
  courses_ += start.count / 4;
  if (start.wait + (start.stands ? stops_ : 0.0) + straight / query_.pace.v > latest + rounding_of_times) return false;
  const bool nowhere = dx * dx + dy * dy < 1e-12;
  const double heading =
      nowhere ? (first == 0.0 ? start.at.theta : end.theta) : math::atan2(dy, dx) - math::atan2(h, straight);
  course.start = &start;
  course.share = 1.0;
  course.count = 0;
  course.turns_last = last == 0.0;
  course.turn = first == 0.0 ? wrap_angle(heading - start.at.theta) : 0.0;
  course.last_turn = last == 0.0 ? wrap_angle(end.theta - heading) : 0.0;
  const auto add = [&](double curvature, double length) {
    if (length < 1e-6) return;
    const double limit = std::min(query_.pace.v, query_.pace.omega / (query_.k_y + std::abs(curvature)));
    course.pieces[course.count++] = {curvature, length, limit};
  };
  for (std::size_t k = 0; k < start.count; ++k) course.pieces[course.count++] = start.pieces[k];
  if (first != 0.0) add(first, std::abs(r_1) * turned_to(std::copysign(1.0, r_1), heading - start.at.theta));
  add(0.0, straight);
  if (last != 0.0) add(last, std::abs(r_2) * turned_to(std::copysign(1.0, r_2), end.theta - heading));
  return first != 0.0 || turns_at_its_end(start);
}

/// The speeds between the pieces, with bounded acceleration. False where the first or last cannot be met.
bool Merge::speeds(const Course& course, double v_1, Speeds& u) const noexcept {
  const double a = query_.pace.acceleration;
  const std::size_t n = course.count;
  u[0] = course.start->stands ? 0.0 : query_.v;
  for (std::size_t k = 0; k < n; ++k) {
    const Piece& piece = course.pieces[k];
    double next = k + 1 < n ? course.share * std::min(piece.limit, course.pieces[k + 1].limit) : v_1;
    if (course.start->rests && k + 1 == course.start->count) next = 0.0;
    if (u[k] > piece.limit + 1e-9) return false;
    u[k + 1] = std::min(next, std::sqrt(u[k] * u[k] + 2.0 * a * piece.length));
  }
  if (u[n] < v_1 - 1e-6 || (n > 0 && v_1 > course.pieces[n - 1].limit + 1e-9)) return false;
  const double begins = u[0];
  for (std::size_t k = n; k-- > 0;)
    u[k] = std::min(u[k], std::sqrt(u[k + 1] * u[k + 1] + 2.0 * a * course.pieces[k].length));
  return n == 0 || u[0] > begins - 1e-6;
}

double Merge::duration(const Course& course, const ReferencePoint& to) const noexcept {
  const double a = query_.pace.acceleration, v_1 = std::max(0.0, to.twist.v);
  Speeds u{};
  if (!speeds(course, course.turns_last ? 0.0 : v_1, u)) return never;
  double t = course.start->wait + (course.start->stands ? stops_ : 0.0);
  t += query_.pace.turn_time(course.start->turn) + query_.pace.turn_time(course.turn) +
       query_.pace.turn_time(course.last_turn);
  if (course.turns_last) t += v_1 / a;
  for (std::size_t k = 0; k < course.count; ++k) {
    const Piece& piece = course.pieces[k];
    const double peak = std::min(std::max({course.share * piece.limit, u[k], u[k + 1]}),
                                 std::sqrt(piece.length * a + 0.5 * (u[k] * u[k] + u[k + 1] * u[k + 1])));
    const double ramps = (2.0 * peak * peak - u[k] * u[k] - u[k + 1] * u[k + 1]) / (2.0 * a);
    t += (2.0 * peak - u[k] - u[k + 1]) / a + std::max(0.0, piece.length - ramps) / peak;
  }
  return t;
}

bool Merge::lay(const Course& course, const ReferencePoint& to, double wait, Route& route) const noexcept {
  const double a = query_.pace.acceleration, v_1 = std::max(0.0, to.twist.v);
  Speeds u{};
  if (!speeds(course, course.turns_last ? 0.0 : v_1, u)) return false;
  if (course.start->stands)
    route.brake(query_.from, query_.v, query_.pace);
  else
    route.stand(query_.from);
  const std::size_t waits_before = course.start->rests ? course.start->count : 0;  // that piece
  bool fits =
      route.wait(course.start->wait + (waits_before == 0 ? wait : 0.0)) && route.turn(course.start->turn, query_.pace);
  const auto set_off_again = [&] {
    fits = fits && (waits_before == 0 || route.wait(wait)) && route.turn(course.turn, query_.pace);
  };
  for (std::size_t k = 0; k < course.count; ++k) {
    if (k == waits_before) set_off_again();
    const Piece& piece = course.pieces[k];
    const double peak = std::min(std::max({course.share * piece.limit, u[k], u[k + 1]}),
                                 std::sqrt(piece.length * a + 0.5 * (u[k] * u[k] + u[k + 1] * u[k + 1])));
    const double up = (peak * peak - u[k] * u[k]) / (2.0 * a), down = (peak * peak - u[k + 1] * u[k + 1]) / (2.0 * a);
    fits = fits && route.roll(up, piece.curvature, u[k], peak) &&
           route.roll(piece.length - up - down, piece.curvature, peak, peak) &&
           route.roll(down, piece.curvature, peak, u[k + 1]);
  }
  if (course.count <= waits_before) set_off_again();
  fits = fits && route.turn(course.last_turn, query_.pace);
  const double bend = v_1 > drives ? to.twist.omega / v_1 : 0.0;
  if (course.turns_last) fits = fits && route.roll(0.5 * v_1 * v_1 / a, bend, 0.0, v_1);
  return fits && (v_1 > drives ? route.roll(v_1 * goes_on, bend, v_1, v_1) : route.wait(goes_on));
}

/// Whether the shield would leave it alone between the samples k - 1 and k of the traffic: what is left over what is to
/// be kept shrinks no faster than it allows, and where there is nothing left, the distance does not shrink.
bool Merge::clear(std::size_t k, const Route::Position& before, const Route::Position& here) const noexcept {
  for (std::size_t j = 0; j < traffic_->robots(); ++j) {
    if (j == query_.robot || !traffic_->present(j)) continue;
    const double closer = query_.smaller.empty() ? 0.0 : query_.smaller[query_.robot] + query_.smaller[j];
    const double keep = query_.keep - closer, near = keep + reach;
    const double dx = traffic_->x(j, k) - here.x, dy = traffic_->y(j, k) - here.y, squared = dx * dx + dy * dy;
    if (squared > near * near) continue;
    const double left = std::sqrt(squared) - keep;
    const double was = math::hypot(traffic_->x(j, k - 1) - before.x, traffic_->y(j, k - 1) - before.y) - keep;
    if (left < (was > 0.0 ? shrinks_ * was : was) - merge_rounding) return false;
  }
  return true;
}

bool Merge::clear(const Route& route, double joins, double until) noexcept {
  const auto last = std::min(Traffic::steps - 1, static_cast<std::size_t>(until / Traffic::step + 1e-9));
  const auto position = [&](std::size_t k, std::size_t& segment) {
    const double t = Traffic::step * static_cast<double>(k);
    return t < joins ? route.position(t, segment) : place_at_sample(k);
  };
  const auto clear_at = [&](std::size_t k, const Route::Position& before, const Route::Position& here) {
    const double t = Traffic::step * static_cast<double>(k);
    if (query_.crowded && t >= query_.grace && !clear(k, before, here)) return false;
    return !query_.obstacles || t >= joins || lattice_->free({before.x, before.y}, {here.x, here.y});
  };
  // Most ways that are blocked are blocked for a while: looked at here and there, few of their samples tell.
  std::size_t segment = 0;
  for (std::size_t k = coarse; k <= last; k += coarse) {
    samples_ += 2;
    const Route::Position before = position(k - 1, segment);
    if (!clear_at(k, before, position(k, segment))) return false;
  }
  segment = 0;
  Route::Position before{query_.from.x, query_.from.y};
  for (std::size_t k = 1; k <= last; ++k) {
    const Route::Position here = position(k, segment);
    ++samples_;
    if (!clear_at(k, before, here)) return false;
    before = here;
  }
  return true;
}

/// When the first of the others comes to where the robot stands. [s]
double Merge::stands_until() noexcept {
  if (!query_.crowded) return never;
  const auto first = static_cast<std::size_t>(std::max(stops_ / Traffic::step + 1.0, query_.grace / Traffic::step));
  constexpr auto last = static_cast<std::size_t>(look_ahead / Traffic::step);
  const Route::Position here{stop_.x, stop_.y};
  for (std::size_t k = first + 1; k <= last; ++k) {
    ++samples_;
    if (!clear(k, here, here)) return Traffic::step * static_cast<double>(k);
  }
  return never;
}

/// One way that is at its place at that time. What it would be there too soon, it waits at first, or drives slower.
bool Merge::try_at(const Trial& trial, Way& best, Route& route) noexcept {
  const Start& start = starts_[trial.start];
  const ReferencePoint to = place(trial.joins);
  Course course;
  if (!plan(start, trial.kind, to, trial.joins, course)) return false;
  double left = trial.joins - duration(course, to);
  if (!(left >= -1e-6)) return false;
  const double turns = query_.pace.turn_time(start.turn) + query_.pace.turn_time(course.turn);
  if (start.stands && !start.rests && stops_ + start.wait + left + turns > stands_until_) {
    next_[trial.start * kinds + trial.kind] = never;  // later it would stand there even longer
    return false;
  }
  if (!start.stands && left > 1e-3) {
    double low = 0.2, high = 1.0;  // share of the speeds
    for (int k = 0; k < 12; ++k) {
      course.share = 0.5 * (low + high);
      (duration(course, to) <= trial.joins ? high : low) = course.share;
    }
    course.share = high;
    left = trial.joins - duration(course, to);
    if (!(left >= -1e-6) || left > 0.05) return false;
    left = 0.0;
  }
  if (!lay(course, to, std::max(0.0, left), laid_) || !clear(laid_, trial.joins, std::max(trial.joins, query_.watched)))
    return false;
  best = {true, trial.joins};
  route = laid_;
  return true;
}

/// The soonest of the ways from some starts, tried for ever later times.
bool Merge::search(std::size_t first, std::size_t last, bool few, std::size_t most, Way& best, Route& route) noexcept {
  std::fill(next_.begin(), next_.end(), 0.0);
  std::fill(tries_.begin(), tries_.end(), 0);
  Course course;
  const double end = std::min({look_ahead, best.joins, query_.before});
  for (double t = time_step; t < end && work() < most; t += time_step) {
    if (leads_into_obstacle_[static_cast<std::size_t>(t / time_step)] != 0) continue;
    const ReferencePoint to = place(t);
    if (math::hypot(to.pose.x - query_.from.x, to.pose.y - query_.from.y) > query_.pace.v * t + merge_rounding)
      continue;
    trials_.clear();
    for (std::size_t s = first; s < last; ++s)
      for (std::size_t kind = turns_at_its_end(starts_[s]) ? 0 : bends; kind < kinds; ++kind) {
        const std::size_t both = s * kinds + kind;
        if (t < next_[both] || t < starts_[s].takes || (few && (kind / bends > 2 || kind % bends > 2))) continue;
        if (!plan(starts_[s], kind, to, t, course) || duration(course, to) > t) continue;
        double joins = t;
        if (tries_[both] == 0) {  // since when?
          double low = t - time_step;
          for (int k = 0; k < 8; ++k) {
            const double middle = 0.5 * (low + joins);
            const ReferencePoint there = place(middle);
            (plan(starts_[s], kind, there, middle, course) && duration(course, there) <= middle ? joins : low) = middle;
          }
        }
        next_[both] = tries_[both] < later.size() ? t + later[tries_[both]] : never;
        ++tries_[both];
        trials_.push_back({joins, s, kind});
      }
    std::sort(trials_.begin(), trials_.end());
    for (const Trial& trial : trials_)
      if (trial.joins < end && try_at(trial, best, route)) return true;
  }
  return false;
}

/// Whether what a start begins with can be driven at once.
bool Merge::begins_clear(const Start& start) noexcept {
  Course course;
  course.start = &start;
  course.pieces = {};
  std::copy_n(start.pieces.begin(), start.count, course.pieces.begin());
  course.count = start.count;
  const ReferencePoint to{start.at, {start.rests ? 0.0 : start.pieces[start.count - 1].limit, 0.0}};
  if (!lay(course, to, 0.0, laid_)) return false;
  const double ends = laid_.duration() - goes_on;
  return clear(laid_, never, ends);
}

/// Starts by points of rings round the robot, where the way there is free.
void Merge::go_aside() noexcept {
  const std::size_t directions = ring / radii.size();
  for (const double radius : radii)
    for (std::size_t k = 0; k < directions; ++k) {
      const double heading = 2.0 * pi * static_cast<double>(k) / static_cast<double>(directions);
      const Pose to{stop_.x + radius * math::cos(heading), stop_.y + radius * math::sin(heading), wrap_angle(heading)};
      if (!lattice_->free(to.x, to.y) || !lattice_->free({stop_.x, stop_.y}, {to.x, to.y})) continue;
      Start& start = starts_[start_count_];
      start = {true, wrap_angle(heading - stop_.theta), {}, 1, to, 0.0, 0.0, true};
      start.pieces[0] = {0.0, radius, query_.pace.v};
      for (const double wait : waits) {
        start.wait = wait;
        if (wait > stands_until_ || !begins_clear(start)) continue;
        ++start_count_;
        break;
      }
    }
}

/// So far beside the place and behind it, with its heading.
Pose Merge::beside(double t, double aside, double back) const noexcept {
  const Pose on = place(t).pose;
  const auto [n, c] = math::sincos(on.theta);
  return {on.x - back * c - aside * n, on.y - back * n + aside * c, on.theta};
}

/// The soonest way to a pose at top speed, sooner than `before`.
bool Merge::come_to(const Start& from, const Pose& to, double before, Start& start) noexcept {
  Course course, soonest;
  double least = before;
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    if (kind % bends == 0 || !plan(from, kind, {to, {query_.pace.v, 0.0}}, least, course)) continue;
    if (const double takes = duration(course, {to, {query_.pace.v, 0.0}}); takes < least)
      least = takes, soonest = course;
  }
  if (least == before) return false;
  start = {from.stands, soonest.turn, soonest.pieces, soonest.count, to, from.wait, least, false};
  return true;
}

/// The soonest way to a point beside the place; beside where the place is `after` or later.
bool Merge::come_beside(const Start& from, double back, double aside, double after, Start& start) noexcept {
  double t = std::max(from.wait, after);
  while ((t += time_step) < std::min(look_ahead, query_.before)) {
    const Pose to = beside(t, aside, back);
    if (math::hypot(to.x - stop_.x, to.y - stop_.y) > query_.pace.v * t + merge_rounding) continue;
    if (lattice_->free(to.x, to.y) && come_to(from, to, t, start)) return begins_clear(start);
  }
  return false;
}

/// Starts that end beside the place.
void Merge::go_abreast(std::size_t direct, std::size_t most) noexcept {
  const std::size_t end = start_count_ + lanes;
  for (const double aside : lane)
    for (const double back : lane_back) begin_beside(direct, end, most, back, aside, 0.0);
}

/// When its place was nearest to where the robot is, at most `look_back` ago. [s]
double Merge::was_nearest() const noexcept {
  double least = never, nearest = 0.0;
  for (std::size_t k = 0; time_step * static_cast<double>(k) <= look_back; ++k) {
    const double t = -time_step * static_cast<double>(k);
    const Pose on = place(t).pose;
    const double away = math::hypot(on.x - stop_.x, on.y - stop_.y);
    if (away < least) least = away, nearest = t;
  }
  return nearest;
}

/// Starts that overtake those who follow the place: in a lane beside its path, from near the robot on.
void Merge::overtake(std::size_t direct, std::size_t most) noexcept {
  const std::size_t end = start_count_ + lanes;
  const double nearest = was_nearest();
  if (nearest >= -entries[0]) return;
  for (std::size_t s = 0; s < direct; ++s)
    for (const double aside : lane) {
      const std::size_t before = start_count_;
      for (const double wait : waits) {
        if (start_count_ > before || start_count_ + lane_back.size() > end || work() >= most) break;
        if (wait > 0.0 && (!starts_[s].stands || wait > stands_until_)) break;
        // A point that is too near can only be entered after a loop: where it is farthest along the lane comes first.
        std::array<Start, entries.size()> enters;
        std::array<std::pair<double, std::size_t>, entries.size()> order;
        starts_[s].wait = wait;
        for (std::size_t k = 0; k < entries.size(); ++k) {
          const double t = nearest + entries[k];
          const Pose to = beside(t, aside, 0.0);
          const bool found = lattice_->free(to.x, to.y) && come_to(starts_[s], to, look_ahead, enters[k]);
          order[k] = {found ? enters[k].takes - entries[k] * place(t).twist.v / query_.pace.v : never, k};
        }
        starts_[s].wait = 0.0;
        std::sort(order.begin(), order.end());
        for (const auto& [after, k] : order)
          if (after < never && start_count_ == before && begins_clear(enters[k]))
            follow_lane(nearest + entries[k], aside, enters[k]);
      }
    }
}

/// Follows the lane from where the place was at time t, until it is abreast of the place, a little before and a little
/// later: a start for each.
void Merge::follow_lane(double t, double aside, Start start) noexcept {
  const std::size_t entered = start.count;
  for (const double back : lane_back) {
    for (;;) {
      const double v = place(t).twist.v;
      if (v < drives || start.takes > look_ahead) return;
      if (t >= start.takes - back / v) break;
      const Pose here = beside(t, aside, 0.0), there = beside(t + time_step, aside, 0.0);
      const auto [sin, cos] = math::sincos(here.theta);
      const double ahead = cos * (there.x - here.x) + sin * (there.y - here.y);
      const double turn = wrap_angle(there.theta - here.theta);
      if (ahead < 1e-4) return;  // a corner narrower than the lane
      const double length = std::abs(turn) < 1e-6 ? ahead : ahead * turn / math::sin(turn), curvature = turn / length;
      const double limit = std::min(query_.pace.v, query_.pace.omega / (query_.k_y + std::abs(curvature)));
      if (start.count == entered || std::abs(start.pieces[start.count - 1].curvature - curvature) > same_curvature) {
        if (start.count + 1 + curve_pieces > start.pieces.size()) return;
        start.pieces[start.count++] = {curvature, 0.0, limit};
      }
      Piece& last = start.pieces[start.count - 1];
      last.length += length;
      start.at = advance(start.at, {length, last.curvature * length}, 1.0);
      start.takes += length / last.limit;
      t += time_step;
      samples_ += 2;
    }
    if (!begins_clear(start)) return;
    starts_[start_count_++] = start;
  }
}

/// Starts that end beside where the place comes out behind an obstacle.
void Merge::go_past_obstacle(std::size_t direct, std::size_t most) noexcept {
  const std::size_t end = start_count_ + lanes;
  for (const double aside : past_obstacles) begin_beside(direct, end, most, 0.0, aside, lane_free_from_);
}

void Merge::begin_beside(std::size_t direct, std::size_t end, std::size_t most, double back, double aside,
                         double after) noexcept {
  for (std::size_t s = 0; s < direct; ++s)
    for (const double wait : waits) {
      if (start_count_ == end || work() >= most || (wait > 0.0 && (!starts_[s].stands || wait > stands_until_))) break;
      starts_[s].wait = wait;
      const bool found = come_beside(starts_[s], back, aside, after, starts_[start_count_]);
      starts_[s].wait = 0.0;
      if (!found) continue;
      ++start_count_;
      break;
    }
}

Merge::Way Merge::find(const Query& query, const Reference& reference, const Lattice& lattice, const Traffic& traffic,
                       Route& route) noexcept {
  query_ = query;
  reference_ = &reference;
  lattice_ = &lattice;
  traffic_ = &traffic;
  courses_ = samples_ = 0;
  shrinks_ = math::exp(-0.95 * query.gamma * Traffic::step);
  knows_place_.fill(0);
  const double slow = slow_arc * query.pace.v;
  const double tight = std::max(0.0, query.pace.omega / slow - query.k_y);
  const double wide = std::max(0.0, query.pace.omega / query.pace.v - query.k_y);
  curvatures_ = {0.0, tight, -tight, wide, -wide};
  stop_ = Route::stop(query.from, query.v, query.pace);
  stops_ = Route::stop_time(query.v, query.pace);
  find_ways_into_obstacles();
  stands_until_ = stands_until();
  start_count_ = 0;
  starts_[start_count_++] = {true, 0.0, {}, 0, stop_, 0.0, 0.0, false};
  if (query.v > drives && query.v <= query.pace.v) {
    const double way = goes_straight * query.v;
    Start& start = starts_[start_count_++] = {false, 0.0, {}, 1, advance(query.from, {way, 0.0}, 1.0), 0.0, 0.0, false};
    start.pieces[0] = {0.0, way, query.v};
  }
  Way best;
  const std::size_t direct = start_count_;
  search(0, direct, false, query.most_work / (lane_blocked_ ? 4 : 2), best, route);
  if ((!query.crowded && !lane_blocked_) || (best.found && best.joins < query.enough)) return best;
  if (lane_blocked_) {
    go_past_obstacle(direct, query.most_work / 2);
    search(direct, start_count_, true, 5 * query.most_work / 8, best, route);
  }
  const std::size_t behind = start_count_;
  overtake(direct, 3 * query.most_work / 4);
  const std::size_t overtakes = start_count_;
  search(behind, overtakes, true, 7 * query.most_work / 8, best, route);
  go_aside();
  const std::size_t aside = start_count_;
  search(overtakes, aside, true, query.most_work, best, route);
  if (work() >= query.most_work) return best;
  go_abreast(direct, query.most_work);
  search(aside, start_count_, true, query.most_work, best, route);
  return best;
}

}  // namespace skein::core
