#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/avoidance/obstacle.h"
#include "core/safety/shield.h"
#include "draw.h"

namespace skein::test {

/// Robots close together, and what each wants to drive: one problem for the shield.
struct Crowd {
  core::ShieldParameters parameters;
  std::vector<core::Pose> poses;
  std::vector<core::Obstacle> obstacles;
  std::vector<double> v_limit;
  std::vector<core::Twist> wanted;

  std::size_t robots() const { return poses.size(); }
};

/// Robots in so small a square that several are near one another; the least distance between two (or to an obstacle's
/// edge, in proportion) is `closest` times what the shield keeps.
inline Crowd random_crowd(Draw& draw, std::size_t robots, std::size_t obstacles, double closest = 1.0) {
  Crowd crowd;
  crowd.parameters.distance = draw.between(0.07, 0.1);
  crowd.parameters.gamma = draw.decades(0.0, 1.3);
  const double keep = crowd.parameters.distance;
  double side = 1.2 * keep * std::sqrt(static_cast<double>(robots + obstacles));
  const auto keeps_clear = [&](double x, double y, double least) {
    side *= 1.001;  // a square that turns out too small grows
    return std::all_of(crowd.poses.begin(), crowd.poses.end(),
                       [&](const core::Pose& p) { return std::hypot(p.x - x, p.y - y) >= closest * least; }) &&
           std::all_of(crowd.obstacles.begin(), crowd.obstacles.end(), [&](const core::Obstacle& o) {
             return std::hypot(o.x - x, o.y - y) >= closest * (keep - core::standard_radius + o.radius);
           });
  };
  while (crowd.obstacles.size() < obstacles)
    crowd.obstacles.push_back({draw.between(-side, side), draw.between(-side, side), draw.between(0.0, 0.1)});
  while (crowd.robots() < robots) {
    core::Pose pose{draw.between(-side, side), draw.between(-side, side), draw.angle()};
    if (draw.chance(0.2) && !crowd.poses.empty()) {  // exactly as near as may be, and head-on or straight across
      const core::Pose& other = crowd.poses.back();
      const double direction = draw.angle();
      pose = {other.x + closest * keep * std::cos(direction), other.y + closest * keep * std::sin(direction),
              core::wrap_angle(direction + (draw.chance(0.5) ? core::pi : 0.5 * core::pi))};
    }
    if (!keeps_clear(pose.x, pose.y, keep * (1.0 - 1e-12))) continue;
    crowd.poses.push_back(pose);
    crowd.v_limit.push_back(draw.chance(0.1) ? 0.0 : draw.between(0.02, 0.13));
    const double limit = crowd.v_limit.back();
    const double v = draw.chance(0.3) ? draw.sign() * limit : draw.between(-1.0, 1.0) * limit;
    crowd.wanted.push_back({v, draw.between(-2.0, 2.0)});
  }
  return crowd;
}

/// a . v >= b
struct HalfSpace {
  Eigen::VectorXd a;
  double b = 0.0;
};

/// The shield's conditions for every pair and every obstacle, near or far, straight from the definition.
inline std::vector<HalfSpace> conditions(const Crowd& crowd) {
  const auto n = static_cast<Eigen::Index>(crowd.robots());
  const auto& p = crowd.parameters;
  std::vector<HalfSpace> all;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& here = crowd.poses[static_cast<std::size_t>(i)];
    const Eigen::Vector2d at(here.x, here.y), heading(std::cos(here.theta), std::sin(here.theta));
    for (Eigen::Index j = i + 1; j < n; ++j) {
      const auto& there = crowd.poses[static_cast<std::size_t>(j)];
      const Eigen::Vector2d from = at - Eigen::Vector2d(there.x, there.y);
      HalfSpace c{Eigen::VectorXd::Zero(n), -p.gamma * std::max(0.0, from.norm() - p.distance)};
      c.a(i) = from.normalized().dot(heading);
      c.a(j) = -from.normalized().dot(Eigen::Vector2d(std::cos(there.theta), std::sin(there.theta)));
      all.push_back(c);
    }
    for (const auto& o : crowd.obstacles) {
      const Eigen::Vector2d from = at - Eigen::Vector2d(o.x, o.y);
      const double keep = p.distance - core::standard_radius + o.radius;
      HalfSpace c{Eigen::VectorXd::Zero(n), -p.gamma * std::max(0.0, from.norm() - keep)};
      c.a(i) = from.normalized().dot(heading);
      all.push_back(c);
    }
  }
  return all;
}

/// |v_i| <= v_limit,i as half spaces.
inline std::vector<HalfSpace> speed_limits(const Crowd& crowd) {
  const auto n = static_cast<Eigen::Index>(crowd.robots());
  std::vector<HalfSpace> all;
  for (Eigen::Index i = 0; i < n; ++i)
    for (const double sign : {1.0, -1.0}) {
      all.push_back({Eigen::VectorXd::Zero(n), -crowd.v_limit[static_cast<std::size_t>(i)]});
      all.back().a(i) = sign;
    }
  return all;
}

/// How far v is outside the worst of the half spaces; 0 or less: inside all.
inline double violation(const std::vector<HalfSpace>& half_spaces, const Eigen::VectorXd& v) {
  double worst = 0.0;
  for (const HalfSpace& h : half_spaces) worst = std::max(worst, h.b - h.a.dot(v));
  return worst;
}

/// The point of all half spaces nearest to `wanted`, by trying every set of at most n of them as the ones that hold
/// with equality: slow, and with nothing in common with the shield's method.
inline Eigen::VectorXd nearest_point(const std::vector<HalfSpace>& half_spaces, const Eigen::VectorXd& wanted) {
  const Eigen::Index n = wanted.size();
  Eigen::VectorXd best = Eigen::VectorXd::Zero(n);  // always feasible here
  double best_distance = wanted.squaredNorm();
  std::vector<std::size_t> active;
  const auto try_active = [&] {
    const auto m = static_cast<Eigen::Index>(active.size());
    Eigen::VectorXd v = wanted;
    if (m > 0) {
      Eigen::MatrixXd a(m, n);
      Eigen::VectorXd b(m);
      for (Eigen::Index k = 0; k < m; ++k) {
        a.row(k) = half_spaces[active[static_cast<std::size_t>(k)]].a.transpose();
        b(k) = half_spaces[active[static_cast<std::size_t>(k)]].b;
      }
      const auto qr = a.completeOrthogonalDecomposition();
      if (qr.rank() < m) return;
      v += qr.solve(b - a * wanted);  // the least correction that meets the equalities
    }
    const double distance = (v - wanted).squaredNorm();
    if (distance < best_distance && violation(half_spaces, v) <= 1e-12) best = v, best_distance = distance;
  };
  const auto extend = [&](auto&& self, std::size_t first) -> void {
    try_active();
    if (static_cast<Eigen::Index>(active.size()) == n) return;
    for (std::size_t k = first; k < half_spaces.size(); ++k) {
      active.push_back(k);
      self(self, k + 1);
      active.pop_back();
    }
  };
  extend(extend, 0);
  return best;
}

inline Eigen::VectorXd speeds(const std::vector<core::Twist>& commands) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(commands.size()));
  for (std::size_t i = 0; i < commands.size(); ++i) v(static_cast<Eigen::Index>(i)) = commands[i].v;
  return v;
}

}  // namespace skein::test
