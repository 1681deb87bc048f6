// Ways back to places that drive on, and who yields to whom.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/planning/planner.h"

namespace skein::core {
namespace {

constexpr double all_speed = 0.995;     // of what (18f) leaves
constexpr double all_turning = 0.97;    // of what (18g) leaves
constexpr double horizon = 45.0;        // [s]
constexpr double leaves_within = 2.0;   // so long one without a way yet is taken to stand where it is [s]
constexpr double may_be_better = 0.6;   // who is so much later than alone asks others to yield [s]
constexpr double worth_it = 0.3;        // yielding brings at least so much [s]
constexpr double least_hurry = 0.1;     // who cannot catch up faster than that does not yield
constexpr std::size_t most_asked = 6;   // the nearest
constexpr std::array<double, 5> stands_for{0.5, 1.2, 2.0, 3.0, 4.5};  // [s]

}  // namespace

/// One robot after the other. Whoever has no way yet is taken to stand for a while, and to be away then.
void Planner::merge_in_order(bool backwards, const Scene& scene, const Merge::Query& like) noexcept {
  Merging& m = merging_;
  double total = m.delay.ends() > scene.t ? m.delay.ends() - scene.t : 0.0;
  for (std::size_t k = 0; k < m.count; ++k)
    traffic_.stands(m.robots[k], group_.from[m.robots[k]].x, group_.from[m.robots[k]].y, leaves_within);
  for (std::size_t k = 0; k < m.count; ++k) {
    const std::size_t at = backwards ? m.count - 1 - k : k, i = m.robots[at];
    Merge::Query query = like;
    query.robot = i;
    query.from = m.from[at];
    query.v = m.v[at];
    query.before = m.best_total;
    query.enough = m.soonest[at] + may_be_better;
    const Merge::Way way = merge_.find(query, *reference_, lattice_, traffic_, m.tried[at]);
    spent_ += merge_.work();
    if (!way.found) return;
    m.tried_joins[at] = way.joins;
    total = std::max(total, way.joins);
    if (k + 1 < m.count) traffic_.joins(i, m.tried[at], 0.0, way.joins, *reference_, scene.t, horizon);
  }
  if (total >= m.best_total) return;
  m.best_total = total;
  m.best = m.tried;
  m.best_joins = m.tried_joins;
  m.best_delay = m.delay;
  m.best_yields = m.yields;
}

void Planner::merge_all(const Scene& scene, const Merge::Query& like) noexcept {
  for (std::size_t j = 0; j < robots_.size(); ++j)
    if (merging_.yields[j])
      traffic_.copy(j, expected_, scene.t, merging_.delay);
    else
      traffic_.copy(j, expected_);
  merge_in_order(false, scene, like);
  if (merging_.count > 1) merge_in_order(true, scene, like);
}

/// Robot `first`, and everybody who only follows its reference and would come too near to one that yields.
void Planner::who_yields(std::size_t first, const Scene& scene, const Delay& delay) noexcept {
  Merging& m = merging_;
  const std::size_t n = robots_.size();
  std::fill(m.yields.begin(), m.yields.end(), std::uint8_t{0});
  m.yields[first] = 1;
  const double keep = setup_.shield_distance + 0.004 + 2.0 * scene.doubt;
  const double shrinks = std::exp(-0.95 * setup_.shield_gamma * Traffic::step);
  const auto steps = std::min(Traffic::steps - 1, static_cast<std::size_t>((delay.ends() - scene.t) / Traffic::step));
  traffic_.copy(first, expected_, scene.t, delay);
  for (bool more = true; more;) {
    more = false;
    for (std::size_t j = 0; j < n && !more; ++j) {
      if (m.yields[j] || robots_[j].state != State::nominal || !expected_.present(j) || scene.out[j]) continue;
      for (std::size_t i = 0; i < n && !more; ++i) {
        if (!m.yields[i]) continue;
        double was = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k <= steps && !more; ++k) {
          const double left =
              std::hypot(traffic_.x(i, k) - expected_.x(j, k), traffic_.y(i, k) - expected_.y(j, k)) - keep;
          more = left < 0.0 && left < was - 1e-4 ? true : k > 0 && left < shrinks * was - 1e-4 && was > 0.0;
          was = left;
        }
      }
      if (!more) continue;
      m.yields[j] = 1;
      traffic_.copy(j, expected_, scene.t, delay);
    }
  }
}

void Planner::plan_merges(const Scene& scene, const Gains& gains, std::span<const ReferencePoint> nominal) noexcept {
  Merging& m = merging_;
  const std::size_t n = robots_.size();
  Merge::Query like;
  like.t = scene.t;
  like.k_y = gains.k_y;
  like.gamma = setup_.shield_gamma;
  like.pace = pace_;
  like.pace.v = all_speed * free_v(gains, m.robots[0]);
  like.pace.omega = all_turning * free_omega(gains, m.robots[0]);
  for (std::size_t k = 0; k < m.count; ++k) {
    const Start start = begin_route(m.robots[k], scene);
    m.from[k] = start.from;
    m.v[k] = std::max(0.0, start.v);
  }
  bool somebody_yields = false;
  for (std::size_t j = 0; j < n; ++j) {
    expect(j, scene, nominal);
    somebody_yields = somebody_yields || robots_[j].state == State::yielding;
  }
  for (std::size_t j = 0; j < n; ++j) expected_.copy(j, traffic_);

  // Were nobody there.
  double soonest = 0.0;
  for (std::size_t k = 0; k < m.count; ++k) {
    Merge::Query query = like;
    query.robot = m.robots[k];
    query.from = m.from[k];
    query.v = m.v[k];
    query.crowded = false;
    m.soonest[k] = merge_.find(query, *reference_, lattice_, traffic_, m.tried[k]).joins;
    spent_ += merge_.work();
    soonest = std::max(soonest, m.soonest[k]);
  }
  const ReferenceDemand demand = reference_->demand(gains.k_y);
  const double hurry = demand.v > 0.0 && demand.turning > 0.0
                           ? std::min(like.pace.v / demand.v, like.pace.omega / demand.turning) - 1.0
                           : 0.0;

  struct Care {
    double room, grace;
  };
  constexpr double anywhere = -1.0;
  m.best_total = never;
  for (const Care care : {Care{0.004, 0.0}, Care{0.001, 0.0}, Care{0.003, 2.5}, Care{anywhere, 0.0}}) {
    like.crowded = care.room != anywhere;
    like.keep = setup_.shield_distance + care.room + 2.0 * scene.doubt;
    like.grace = care.grace;
    like.watched = 0.0;
    m.delay = Delay();
    std::fill(m.yields.begin(), m.yields.end(), std::uint8_t{0});
    merge_all(scene, like);
    if (like.crowded && !somebody_yields && hurry > least_hurry && m.best_total > soonest + may_be_better)
      for (const double stands : stands_for) {
        const Delay delay(scene.t, stands, hurry, pace_.acceleration / demand.v);
        if (delay.ends() - scene.t > m.best_total - worth_it) break;
        std::fill(m.last_yields.begin(), m.last_yields.end(), std::uint8_t{0});
        for (std::size_t j = 0; j < n; ++j) {
          if (robots_[j].state != State::nominal || scene.out[j] || !expected_.present(j)) continue;
          if (nominal[j].twist == Twist{}) continue;
          bool near = false;
          for (std::size_t k = 0; k < m.count; ++k) near = near || distance(scene.poses[j], m.from[k]) < 0.6;
          if (!near) continue;
          who_yields(j, scene, delay);
          if (m.yields == m.last_yields) continue;
          m.last_yields = m.yields;
          m.delay = delay;
          like.watched = delay.ends() - scene.t;
          merge_all(scene, like);
        }
      }
    if (m.best_total < never) break;
  }
  for (std::size_t k = 0; k < m.count; ++k) {
    Robot& robot = robots_[m.robots[k]];
    if (m.best_total == never) {
      robot.no_way = true;
      robot.retry = scene.t + 0.4;
      robot.needs_plan = true;
      continue;
    }
    robot.route = m.best[k];
    robot.joins = m.best_joins[k];
    robot.keeps = setup_.shield_distance + 0.004;
    set_off(m.robots[k], scene.t);
  }
  if (m.best_total == never || std::none_of(m.best_yields.begin(), m.best_yields.end(), [](auto y) { return y != 0; }))
    return;
  yield_ = m.best_delay;
  for (std::size_t j = 0; j < n; ++j)
    if (m.best_yields[j]) robots_[j].state = State::yielding;
}

}  // namespace skein::core
