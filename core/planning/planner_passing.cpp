// Past obstacles on the lane, abreast of a place that drives on.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/elementary.h"
#include "core/planning/planner.h"

namespace skein::core {
namespace {

constexpr double passing_speed = 0.995;     // of what (18f) leaves
constexpr double passing_turning = 0.97;    // of what (18g) leaves
constexpr std::size_t passing_work = 7000;  // of a tick at most [nodes]

}  // namespace

/// Where robot j is expected to be so much later. [s]
Pose Planner::expected_at(std::size_t j, double ahead, const Scene& scene,
                          std::span<const ReferencePoint> nominal) const noexcept {
  const Robot& robot = robots_[j];
  const double t = scene.t + ahead;
  if (stands(j, scene) || robot.state == State::waiting) return scene.poses[j];
  if (robot.state == State::driving && (rests(j, scene) || robot.clock + ahead < robot.joins))
    return robot.route.at(robot.clock + ahead).pose;
  if (robot.state == State::yielding) return reference_->at(j, t - yield_.at(t)).pose;
  if (robot.state == State::passing && t < robot.aside.ends()) return robot.aside.pose(*reference_, j, t);
  return nominal[j].twist == Twist{} && rests(j, scene) ? nominal[j].pose : reference_->at(j, t).pose;
}

/// Whether the shield would leave robot i alone on a way past an obstacle, as long as all robots drive as expected.
bool Planner::meets_nobody(std::size_t i, const Sidestep& way, const Scene& scene,
                           std::span<const ReferencePoint> nominal) noexcept {
  constexpr double step = 0.2, beyond = 0.004, reach = 0.06;
  const double shrinks = math::exp(-0.95 * setup_.shield_gamma * step);
  std::array<Pose, 150> here;
  const auto count = std::min(here.size(), static_cast<std::size_t>((way.ends() - scene.t) / step) + 1);
  for (std::size_t k = 0; k < count; ++k) here[k] = way.pose(*reference_, i, scene.t + step * static_cast<double>(k));
  for (std::size_t j = 0; j < robots_.size(); ++j) {
    if (j == i || std::isnan(scene.poses[j].x)) continue;
    const double keep = setup_.shield_distance + beyond + 2.0 * scene.doubt - closer(i, j);
    double was = never;
    spent_ += count / 8;
    for (std::size_t k = 0; k < count; ++k) {
      const Pose there = expected_at(j, step * static_cast<double>(k), scene, nominal);
      const double left = distance(here[k], there) - keep;
      if (k > 0 && left < reach && left < (was > 0.0 ? std::min(reach, shrinks * was) : was) - 1e-4) return false;
      was = left;
    }
  }
  return true;
}

/// Lets robot i leave the lane in time where its place drives into an obstacle. False: there is none, or no such way
/// past it.
bool Planner::pass_obstacle(std::size_t i, const Scene& scene, const Gains& gains,
                            std::span<const ReferencePoint> nominal) noexcept {
  Robot& robot = robots_[i];
  const bool passes = robot.state == State::passing, yields = robot.state == State::yielding;
  if ((!passes && !yields && robot.state != State::nominal) || robot.needs_plan || rests(i, scene) ||
      nominal[i].twist == Twist{})
    return false;
  if (passes && SidestepSearch::clear(robot.aside, i, scene.t, *reference_, lattice(i))) return true;
  if (spent_ >= passing_work) return passes || robot.state == State::nominal;  // it looks again in a moment
  SidestepSearch::Query query;
  query.robot = i;
  query.most_work = passing_work - spent_;
  query.t = scene.t;
  if (passes) query.from = robot.aside.at(scene.t), query.delay = robot.aside.delay();
  if (yields) query.delay = yield_;
  query.pace.v = passing_speed * free_v(gains, i);
  query.pace.omega = passing_turning * free_omega(gains, i);
  query.k_y = gains.k_y;
  query.gamma = setup_.shield_gamma;
  Sidestep way;
  bool found = false, later = false;
  switch (sidesteps_.begin(query, *reference_, lattice(i))) {
    case SidestepSearch::Lane::free:
      break;
    case SidestepSearch::Lane::later:
      later = true;
      break;
    case SidestepSearch::Lane::blocked:
      while (!found && sidesteps_.next(way)) found = meets_nobody(i, way, scene, nominal);
      spent_ += sidesteps_.work();
      break;
  }
  if (found) {
    robot.aside = way;
    robot.state = State::passing;
    robot.reference = way.shift(*reference_, i, scene.t);
  } else if (passes) {
    robot.needs_plan = true;
  }
  return found || passes || later;
}

}  // namespace skein::core
