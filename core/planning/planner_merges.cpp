// Ways back to places that drive on, and who yields to whom.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/math/elementary.h"
#include "core/planning/planner.h"

namespace skein::core {
namespace {

constexpr double all_speed = 0.995;     // of what (18f) leaves
constexpr double all_turning = 0.97;    // of what (18g) leaves
constexpr double merge_horizon = 45.0;  // [s]
constexpr double merges_within = 2.0;   // so long one without a way yet is taken to stand where it is [s]
constexpr double may_be_better = 0.6;   // who is so much later than alone looks for ways round, in both orders [s]
constexpr double much_better = 2.5;     // only who is so much later than alone searches on for a better way [s]
constexpr double worth_it = 0.3;        // yielding brings at least so much [s]
constexpr double least_hurry = 0.1;     // who cannot catch up faster than that does not yield
constexpr double may_come = 0.02;       // beyond the shield's distance: who comes so near must yield soon [m]
constexpr double worth_taking = 5.0;  // where another robot comes soon, a way so much later than alone is taken at once
                                      // [s]
constexpr std::size_t soon = 10;      // [Traffic::step]
constexpr double near = 0.6;          // who is farther away is not asked to yield [m]
constexpr double longest_search = 0.5;     // where there is a way at all [s]
constexpr double looks_every_time = 0.32;  // who is on its way, for a better one [s]
constexpr double worth_looking = 1.0;      // later than alone [s]
constexpr double worth_change = 0.5;       // sooner than its way [s]
constexpr std::size_t looks_with = 1500;   // [nodes]
// A tick begins no other trial beyond the first, and none takes more than what is then left of the second. Where
// somebody comes soon, many trials with little work each are made before thorough ones, as what yields would solve now
// is lost in half a second. [nodes]
constexpr std::size_t work_each_tick = 600, most_each_tick = 4000, quick_work = 1000;

/// How much room is kept beyond the shield's distance [m], and for how long at first others may come nearer [s]: with
/// room to spare, then as near as the shield allows, then whatever the shield makes of it.
struct Care {
  double room, grace;
};
constexpr std::array<Care, 4> cares{Care{0.004, 0.0}, Care{0.001, 0.0}, Care{0.003, 2.5}, Care{-1.0, 0.0}};
constexpr std::array<double, Planner::holds> stands_for{1.2, 2.0, 0.5, 3.0, 4.5};  // [s]

}  // namespace

/// Robot `first`, and every robot that only follows its reference and would come too near to one that yields. False: so
/// would one that is on its way already, and took them to be elsewhere.
bool Planner::who_yields(std::size_t first, const Scene& scene, const Delay& delay) noexcept {
  Merging& m = merging_;
  const std::size_t n = robots_.size();
  std::fill(m.yields.begin(), m.yields.end(), std::uint8_t{0});
  m.yields[first] = 1;
  const double keep_most = setup_.shield_distance + 0.004 + 2.0 * scene.doubt;
  const double shrinks = math::exp(-0.95 * setup_.shield_gamma * Traffic::step);
  const auto steps = std::min(Traffic::steps - 1, static_cast<std::size_t>((delay.ends() - scene.t) / Traffic::step));
  traffic_.copy(first, expected_, scene.t, delay);
  for (bool more = true; more;) {
    more = false;
    for (std::size_t j = 0; j < n && !more; ++j) {
      const bool on_its_way = robots_[j].state == State::driving || robots_[j].state == State::returning ||
                              robots_[j].state == State::passing;
      const auto last = m.robots.begin() + static_cast<std::ptrdiff_t>(m.count);
      if (m.yields[j] || !expected_.present(j) || stands(j, scene) || std::find(m.robots.begin(), last, j) != last ||
          (robots_[j].state != State::nominal && !on_its_way))
        continue;
      for (std::size_t i = 0; i < n && !more; ++i) {
        if (!m.yields[i]) continue;
        const double keep = keep_most - closer(i, j);
        double was = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k <= steps && !more; ++k) {
          const double left =
              math::hypot(traffic_.x(i, k) - expected_.x(j, k), traffic_.y(i, k) - expected_.y(j, k)) - keep;
          more = left < 0.0 && left < was - 1e-4 ? true : k > 0 && left < shrinks * was - 1e-4 && was > 0.0;
          was = left;
        }
      }
      if (!more) continue;
      if (on_its_way) return false;
      m.yields[j] = 1;
      traffic_.copy(j, expected_, scene.t, delay);
    }
  }
  return true;
}

/// Who comes soonest upon a robot that stands, until it has a way, is the first to be asked to yield.
void Planner::sort_who_comes(const Scene& scene) noexcept {
  Merging& m = merging_;
  const double keep = setup_.shield_distance + may_come + 2.0 * scene.doubt;
  constexpr auto last = static_cast<std::size_t>(sees_ahead / Traffic::step);
  m.urgent.fill(false);
  for (std::size_t j = 0; j < robots_.size(); ++j) {
    m.order[j] = j;
    m.comes[j] = last;
    for (std::size_t k = 0; k < m.count && expected_.present(j); ++k)
      for (std::size_t step = 0; step < last; ++step)
        if (robots_[j].state == State::nominal &&
            math::hypot(expected_.x(j, step) - m.from[k].x, expected_.y(j, step) - m.from[k].y) <
                keep - closer(j, m.robots[k])) {
          m.comes[j] = std::min(m.comes[j], step);
          m.urgent[k] = m.urgent[k] || step < soon;
          break;
        }
  }
  std::sort(m.order.begin(), m.order.end(),
            [&m](std::size_t a, std::size_t b) { return m.comes[a] != m.comes[b] ? m.comes[a] < m.comes[b] : a < b; });
}

/// One robot after the other. A robot without a way yet is assumed to stand for a while, and then to be gone. Returns
/// when all are back at their places, after now, or infinity. [s]
double Planner::merge(const Merging::Trial& trial, const Scene& scene, Merge::Query like, double before) noexcept {
  Merging& m = merging_;
  const Care& care = cares[trial.care];
  like.crowded = care.room >= 0.0;
  like.keep = setup_.shield_distance + care.room + 2.0 * scene.doubt;
  like.grace = care.grace;
  like.before = before;
  double total = 0.0;
  for (std::size_t j = 0; j < robots_.size(); ++j) traffic_.copy(j, expected_);
  if (trial.hold == 0) {
    std::fill(m.yields.begin(), m.yields.end(), std::uint8_t{0});
  } else {
    total = m.delay.ends() - scene.t;
    like.watched = std::max(like.watched, total);
    for (std::size_t j = 0; j < robots_.size(); ++j)
      if (m.yields[j]) traffic_.copy(j, expected_, scene.t, m.delay);
  }
  for (std::size_t k = 0; k < m.count; ++k)
    traffic_.stands(m.robots[k], group_.from[m.robots[k]].x, group_.from[m.robots[k]].y, merges_within);
  for (std::size_t k = 0; k < m.count; ++k) {
    const std::size_t at = trial.backwards ? m.count - 1 - k : k, i = m.robots[at];
    Merge::Query query = like;
    query.robot = i;
    query.pace = m.paces[at];
    query.from = m.from[at];
    query.v = m.v[at];
    query.enough = m.soonest[at] + may_be_better;
    query.most_work = (most_each_tick - std::min(spent_, most_each_tick)) / (m.count - k);
    if (m.urgent[at]) query.most_work = std::min(query.most_work, quick_work);
    const Merge::Way way = merge_.find(query, *reference_, lattice(i), traffic_, m.routes[at]);
    spent_ += merge_.work();
    if (!way.found) return never;
    m.joins[at] = way.joins;
    total = std::max(total, way.joins);
    like.watched = std::max(like.watched, way.joins);
    if (k + 1 < m.count) traffic_.joins(i, m.routes[at], 0.0, way.joins, {*reference_, scene.t, merge_horizon});
  }
  return total;
}

/// The next trial: the other order, others that yield, yielding longer, then less care. False after the last.
bool Planner::advance_trial(const Scene& scene, std::span<const ReferencePoint> nominal, bool may_yield) noexcept {
  Merging& m = merging_;
  Merging::Trial& t = m.next;
  const std::size_t n = robots_.size();
  if (!t.backwards && m.count > 1) return t.backwards = true;
  t.backwards = false;
  if (may_yield && t.care + 1 < cares.size())
    for (t.hold == 0 ? (t.hold = 1, t.first = 0) : ++t.hold; t.first < n; ++t.first, t.hold = 1) {
      const std::size_t j = m.order[t.first];
      if (t.hold > stands_for.size() || robots_[j].state != State::nominal || stands(j, scene) ||
          std::isnan(scene.poses[j].x) || nominal[j].twist == Twist{})
        continue;
      for (std::size_t k = 0; k < m.count; ++k)
        if (distance(scene.poses[j], m.from[k]) < near) return true;
    }
  t = {t.care + 1, 0, 0, false};
  return t.care < cares.size();
}

/// The k-th of those that seek a way, from there.
void Planner::seek(std::size_t k, const Start& from, const Gains& gains) noexcept {
  Merging& m = merging_;
  m.from[k] = from.from;
  m.v[k] = std::max(0.0, from.v);
  m.paces[k] = paces_[m.robots[k]];
  m.paces[k].v = all_speed * free_v(gains, m.robots[k]);
  m.paces[k].omega = all_turning * free_omega(gains, m.robots[k]);
}

/// The expected motion of all robots, and what all searches of this step have in common.
Merge::Query Planner::expect_all(const Scene& scene, const Gains& gains,
                                 std::span<const ReferencePoint> nominal) noexcept {
  Merge::Query like;
  like.t = scene.t;
  like.k_y = gains.k_y;
  like.gamma = setup_.shield_gamma;
  like.smaller = setup_.smaller;
  merging_.somebody_yields = false;
  for (std::size_t j = 0; j < robots_.size(); ++j) {
    const Robot& robot = robots_[j];
    expect(j, scene, nominal);
    expected_.copy(j, traffic_);
    const auto last = merging_.robots.begin() + static_cast<std::ptrdiff_t>(merging_.count);
    const bool seeks = std::find(merging_.robots.begin(), last, j) != last;
    if (robot.state == State::driving && !rests(j, scene) && !seeks)
      like.watched = std::max(like.watched, robot.joins - robot.clock);
    if (robot.state == State::yielding)
      merging_.somebody_yields = true, like.watched = std::max(like.watched, yield_.ends() - scene.t);
  }
  return like;
}

/// When the robots that seek a way would be at their places without any other robots.
void Planner::find_alone(const Merge::Query& like) noexcept {
  Merging& m = merging_;
  for (std::size_t k = 0; k < m.count; ++k) {
    Merge::Query query = like;
    query.robot = m.robots[k];
    query.pace = m.paces[k];
    query.from = m.from[k];
    query.v = m.v[k];
    query.crowded = false;
    query.obstacles = !m.around;
    query.most_work = most_each_tick / (2 * m.count);
    m.soonest[k] = merge_.find(query, *reference_, lattice(m.robots[k]), traffic_, m.routes[k]).joins;
    spent_ += merge_.work();
  }
}

/// By how much clocks of those that yield may run faster afterwards: as much as the slowest of all can follow.
double Planner::hurry_of_all(const Gains& gains) const noexcept {
  const ReferenceDemand demand = reference_->demand(gains.k_y);
  if (!(demand.v > 0.0) || !(demand.turning > 0.0)) return 0.0;
  double hurry = never;
  for (std::size_t j = 0; j < robots_.size(); ++j)
    hurry = std::min(
        hurry,
        std::min(all_speed * free_v(gains, j) / demand.v, all_turning * free_omega(gains, j) / demand.turning) - 1.0);
  return hurry;
}

/// Which robots yield in this trial. False where another robot would be in their way, or where robots yield already:
/// all that yield share one clock, which must not change under them.
bool Planner::let_yield(const Merging::Trial& trial, const Scene& scene, double hurry, double slope) noexcept {
  if (trial.hold == 0) return true;
  if (merging_.somebody_yields) return false;
  merging_.delay = Delay(scene.t, stands_for[trial.hold - 1], hurry, slope);
  spent_ += 5 * robots_.size();
  return who_yields(merging_.order[trial.first], scene, merging_.delay);
}

/// Those that seek a way have found it, and the others yield as it asks for.
void Planner::go(const Scene& scene) noexcept {
  Merging& m = merging_;
  for (std::size_t k = 0; k < m.count; ++k) {
    Robot& robot = robots_[m.robots[k]];
    robot.route = m.routes[k];
    robot.joins = m.joins[k];
    robot.keeps = setup_.shield_distance + cares[0].room;
    set_off(m.robots[k], scene.t);
    robot.looks_at = scene.t + looks_every_time;
  }
  m.searched = 0;
  if (std::none_of(m.yields.begin(), m.yields.end(), [](auto y) { return y != 0; })) return;
  yield_ = m.delay;
  for (std::size_t j = 0; j < robots_.size(); ++j)
    if (m.yields[j]) robots_[j].state = State::yielding;
}

/// On its way, a robot that will be back much later than it could be alone looks for a better way from where it is by
/// then: what blocked it may be gone, and what was found in a hurry may be poor. It drives on meanwhile. A way is only
/// exchanged for one that is sooner by `worth_change`, so that this ends.
void Planner::look_again(std::size_t i, const Scene& scene, const Gains& gains,
                         std::span<const ReferencePoint> nominal) noexcept {
  Merging& m = merging_;
  Robot& robot = robots_[i];
  robot.looks_at = scene.t + looks_every_time;
  const double remaining = robot.joins - robot.clock;
  const Start from{robot.route.at(robot.clock).pose, std::max(0.0, robot.route.twist(robot.clock, 1e-6).v)};
  m.robots[0] = i;
  m.count = 1;
  m.searched = 0;
  m.around = false;
  m.urgent.fill(false);
  seek(0, from, gains);
  m.v[0] = std::min(m.v[0], m.paces[0].v);
  group_.from[i] = Route::stop(from.from, from.v, m.paces[0]);
  Merge::Query like = expect_all(scene, gains, nominal);
  if (lattices_.front().has_obstacles()) like.stays_free = sees_ahead + 0.5;
  find_alone(like);
  if (remaining < m.soonest[0] + worth_looking) {
    robot.looks_at = scene.t + 3.0 * looks_every_time;
    return;
  }
  sort_who_comes(scene);
  m.urgent.fill(true);  // little work each
  const double before = remaining - worth_change, hurry = hurry_of_all(gains);
  const double slope = m.paces[0].acceleration / reference_->demand(gains.k_y).v;
  if (merge({}, scene, like, before) < never) return go(scene);
  const bool may_yield = clock_ == nullptr && !m.somebody_yields && hurry > least_hurry;
  while (may_yield && spent_ < looks_with) {
    m.next = robot.looks;
    if (!advance_trial(scene, nominal, true) || m.next.care > 0) m.next = {};
    robot.looks = m.next;
    if (m.next.hold == 0) return;
    if (!let_yield(m.next, scene, hurry, slope)) continue;
    if (m.delay.ends() - scene.t < before && merge(m.next, scene, like, before) < never) return go(scene);
  }
}

void Planner::plan_merges(const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal) noexcept {
  Merging& m = merging_;
  const std::size_t n = robots_.size();
  for (std::size_t k = 0; k < m.count; ++k) seek(k, begin_route(m.robots[k], scene), gains);
  Merge::Query like = expect_all(scene, gains, nominal);
  // Longer than it looks ahead, or it would leave its place again at once.
  const auto stays_free = [&m] { return m.around ? sees_ahead + 0.5 : 0.0; };
  like.stays_free = stays_free();
  double soonest = 0.0;
  const auto begin = [&](bool around) {
    m.searched = m.count;
    m.around = around;
    like.stays_free = stays_free();
    m.next = {};
    m.decided = false;
    m.began = scene.t;
    m.best_ends = never;
    sort_who_comes(scene);
    spent_ += n;
    for (auto& last : m.last_yields) std::fill(last.begin(), last.end(), std::uint8_t{0});
    find_alone(like);
  };
  const auto urgent = [&m] { return m.urgent[0] || m.urgent[1]; };
  const auto settle = [&] {
    soonest = *std::max_element(m.soonest.begin(), m.soonest.begin() + static_cast<std::ptrdiff_t>(m.count));
  };
  if (m.searched != m.count) begin(lattices_.front().has_obstacles());
  settle();
  const double hurry = hurry_of_all(gains), slope = m.paces[0].acceleration / reference_->demand(gains.k_y).v;

  for (bool more = !m.decided; more;) {
    const double best = m.best_ends - scene.t;
    bool skip = !let_yield(m.next, scene, hurry, slope), enough = false;
    if (m.next.hold > 0) {
      std::vector<std::uint8_t>& last = m.last_yields[m.next.hold - 1];
      skip = skip || (m.yields == last && !m.next.backwards);
      skip = skip || m.delay.ends() - scene.t > best - worth_it;
      last = m.yields;
    }
    if (!skip) {
      const double total = merge(m.next, scene, like, best);
      const bool both_orders = m.next.backwards || m.count == 1;
      if (m.around && total == never && best == never && both_orders) {  // as far as it gets, then
        begin(false);
        settle();
        continue;
      }
      // A robot whose search goes on stands there, and what was found may be blocked by then.
      const bool other_order_left = m.next.hold == 0 && !m.next.backwards && m.count > 1;
      enough = !other_order_left && std::min(total, best) < soonest + much_better;
      enough = enough || (urgent() && total < soonest + worth_taking);
      if (total < best) {
        m.best = m.next;
        m.best_ends = scene.t + total;
        if (enough || total < soonest + may_be_better) return go(scene);
      }
    }
    const std::size_t care = m.next.care;
    const bool was_quick = urgent();
    more = !enough && advance_trial(scene, nominal, clock_ == nullptr && !m.somebody_yields && hurry > least_hurry);
    if (m.next.care != care && m.best_ends < never) more = false;
    if (m.next.care != care && was_quick && more) m.next = {}, m.urgent.fill(false);  // once more, thoroughly
    if (more && m.best_ends < never && scene.t > m.began + longest_search) more = false;
    const std::size_t enough_work = urgent() ? most_each_tick - quick_work : work_each_tick;
    if (more && spent_ >= enough_work) return;  // goes on in the next tick
  }
  if (m.best_ends < never) {  // once more, from here: what took a tick's work is not found with what is left of it
    if (!std::exchange(m.decided, true) && spent_ >= work_each_tick) return;
    if (let_yield(m.best, scene, hurry, slope) && merge(m.best, scene, like, never) < never) return go(scene);
  }
  m.searched = 0;
  for (std::size_t k = 0; k < m.count; ++k) {
    Robot& robot = robots_[m.robots[k]];
    robot.no_way = true;
    robot.retry = scene.t + 0.4;
    robot.needs_plan = true;
  }
}

}  // namespace skein::core
