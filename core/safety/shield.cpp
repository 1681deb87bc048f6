#include "core/safety/shield.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/elementary.h"

namespace skein::core {

Shield::Shield(std::size_t robots, std::size_t obstacles)
    : cos_(robots), sin_(robots), v_(robots), lower_(robots), upper_(robots), near_(robots) {
  constexpr std::size_t edges = 4;
  constraints_.reserve(robots * (robots - 1) / 2 + robots * (obstacles + edges));
}

void Shield::collect(const ShieldParameters& p, const Scene& scene) noexcept {
  const std::span<const Pose> poses = scene.poses;
  const std::span<const double> v_limit = scene.v_limit, doubt = scene.doubt;
  const Sizes& sizes = scene.sizes;
  constraints_.clear();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto [sin, cos] = math::sincos(poses[i].theta);
    cos_[i] = cos, sin_[i] = sin;
  }
  const auto add = [&](std::size_t i, std::size_t j, double dx, double dy, double keep, double fastest_closing,
                       bool moves) {
    const double d = math::hypot(dx, dy);
    // Two robots cannot close in faster than their limits: a pair with more room than that asks for nothing. Nor does
    // one whose distance is not known (NaN).
    if (!(p.gamma * (d - keep) < fastest_closing) || d == 0.0) return;
    const double n_x = dx / d, n_y = dy / d;
    const double a_i = n_x * cos_[i] + n_y * sin_[i];
    const double a_j = moves ? -(n_x * cos_[j] + n_y * sin_[j]) : 0.0;
    constraints_.push_back({i, j, a_i, a_j, -p.gamma * std::max(0.0, d - keep), 0.0});
  };
  // Farther apart than this no robot closes in too fast; the nanometre is for rounding.
  const double fastest = poses.empty() ? 0.0 : *std::max_element(v_limit.begin(), v_limit.end());
  const auto doubt_of = [&](std::size_t i) { return doubt.empty() ? 0.0 : doubt[i]; };
  const double most_doubt = doubt.empty() ? 0.0 : *std::max_element(doubt.begin(), doubt.end());
  near_.sort(poses, p.distance + 2.0 * sizes.most() + 2.0 * most_doubt + 2.0 * fastest / p.gamma + 1e-9);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (const std::uint32_t j : near_.above(i))
      add(i, j, poses[i].x - poses[j].x, poses[i].y - poses[j].y,
          p.distance + doubt_of(i) + doubt_of(j) + sizes.beyond(i, j), v_limit[i] + v_limit[j], true);
    for (const Obstacle& o : scene.obstacles)
      add(i, i, poses[i].x - o.x, poses[i].y - o.y,
          p.distance - standard_radius + o.radius + doubt_of(i) + sizes.beyond(i), v_limit[i], false);
    // n_ij points into the arena. The room may be negative: then the robot may only come back.
    const auto add_edge = [&](double n_x, double n_y, double room) {
      if (!(p.gamma * room < v_limit[i])) return;
      const double a_i = n_x * cos_[i] + n_y * sin_[i];
      constraints_.push_back({i, i, a_i, 0.0, -p.gamma * std::max(0.0, room), 0.0});
    };
    const double keep = p.distance - standard_radius + doubt_of(i) + sizes.beyond(i);
    add_edge(1.0, 0.0, p.half_width - keep + poses[i].x);
    add_edge(-1.0, 0.0, p.half_width - keep - poses[i].x);
    add_edge(0.0, 1.0, p.half_height - keep + poses[i].y);
    add_edge(0.0, -1.0, p.half_height - keep - poses[i].y);
  }
}

/// A robot adrift contributes what it does, and has no say: its share goes into the bound, which stays where standing
/// still satisfies it.
void Shield::fix(std::span<const bool> adrift, std::span<const Twist> commands) noexcept {
  if (adrift.empty()) return;
  for (Constraint& c : constraints_) {
    const bool alone = c.j == c.i;
    if (adrift[c.i]) {
      c.bound = alone ? -std::numeric_limits<double>::infinity() : std::min(0.0, c.bound - c.a_i * commands[c.i].v);
      c.a_i = 0.0;
    }
    if (!alone && adrift[c.j]) {
      c.bound = std::min(0.0, c.bound - c.a_j * commands[c.j].v);
      c.a_j = 0.0;
    }
  }
}

void Shield::apply(const ShieldParameters& parameters, const Scene& scene, std::span<Twist> commands,
                   std::span<bool> touched) noexcept {
  const std::span<const Pose> poses = scene.poses;
  const std::span<const double> v_limit = scene.v_limit;
  std::fill(touched.begin(), touched.end(), false);
  if (!parameters.enabled) return;
  collect(parameters, scene);
  fix(scene.adrift, commands);
  const auto left_of = [&](const Constraint& c) {
    return c.a_i * v_[c.i] + (c.j != c.i ? c.a_j * v_[c.j] : 0.0) - c.bound;
  };
  for (std::size_t i = 0; i < poses.size(); ++i) v_[i] = commands[i].v, lower_[i] = upper_[i] = 0.0;
  if (std::all_of(constraints_.begin(), constraints_.end(), [&](const Constraint& c) { return left_of(c) >= 0.0; }))
    return;

  // Hildreth's method: dual coordinate ascent, one constraint after the other, speed limits included. Converges to the
  // optimum.
  constexpr int most_sweeps = 1000;  // three conditions that nearly agree need hundreds; under 1 ms for 12 robots
  constexpr double converged = 1e-12;
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double largest_change = 0.0;
    const auto ascend = [&](double slack, double norm2, double& multiplier) {
      const double step = std::max(-multiplier, -slack / norm2);
      multiplier += step;
      largest_change = std::max(largest_change, std::abs(step) * std::sqrt(norm2));
      return step;
    };
    for (Constraint& c : constraints_) {
      const double norm2 = c.a_i * c.a_i + c.a_j * c.a_j;
      if (norm2 < 1e-20) continue;  // both drive across the line between them: their speeds do not close the gap
      const double step = ascend(left_of(c), norm2, c.multiplier);
      v_[c.i] += step * c.a_i;
      if (c.j != c.i) v_[c.j] += step * c.a_j;
    }
    for (std::size_t i = 0; i < poses.size(); ++i) {
      v_[i] += ascend(v_[i] + v_limit[i], 1.0, lower_[i]);
      v_[i] -= ascend(v_limit[i] - v_[i], 1.0, upper_[i]);
    }
    if (largest_change < converged) break;
  }

  // Whatever the sweeps left over: hold the limits, then brake the robots that still close in too fast, only these and
  // only as far as needed; at d = D the last digit would otherwise stop all robots. Braking a robot can bring the one
  // behind it too near, hence the passes; should they not settle either, both robots of a pair stop, which ends it
  // after at most as many passes as there are robots.
  for (std::size_t i = 0; i < poses.size(); ++i) v_[i] = std::clamp(v_[i], -v_limit[i], v_limit[i]);
  constexpr double tolerated = 1e-9;  // [m/s]: 40 picometres a tick
  constexpr std::size_t braking_passes = 100;
  bool all_hold = false;
  for (std::size_t pass = 0; !all_hold && pass <= braking_passes + poses.size(); ++pass) {
    all_hold = true;
    for (const Constraint& c : constraints_) {
      if (left_of(c) >= -tolerated) continue;
      all_hold = false;
      const bool alone = c.j == c.i;
      if (pass >= braking_passes) {
        v_[c.i] = v_[c.j] = 0.0;
        continue;
      }
      const double part_i = c.a_i * v_[c.i], part_j = alone ? 0.0 : c.a_j * v_[c.j];
      const double closing = std::min(part_i, 0.0) + std::min(part_j, 0.0);
      const double opening = std::max(part_i, 0.0) + std::max(part_j, 0.0);
      const double share = std::clamp((c.bound - opening) / closing, 0.0, 1.0);
      if (part_i < 0.0) v_[c.i] *= share;
      if (part_j < 0.0) v_[c.j] *= share;
    }
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    touched[i] = std::abs(v_[i] - commands[i].v) > 1e-9;
    if (touched[i]) commands[i].v = v_[i];
  }
}

}  // namespace skein::core
