#include "app/bench/swap_baselines.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/pose.h"
#include "core/math/elementary.h"
#include "core/simulation/random.h"

namespace skein::app {
namespace {

using Eigen::Vector2d;

constexpr double kept = 0.078;  // between midpoints, as by the shield [m]

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}
Vector2d at(const core::Pose& pose) {
  return {pose.x, pose.y};
}
Vector2d ahead(const core::Pose& pose) {
  return {core::math::cos(pose.theta), core::math::sin(pose.theta)};
}

/// How NH-ORCA drives a turn: at once as far as it can, on an arc that ends nearest to the straight line.
struct NhTurn {
  double omega = 0.0, v = 0.0;  // [rad/s, m/s]
  double error = 0.0;           // when it is done [m]
};

NhTurn nh_turn(const core::CommandLimits& limits, double angle, double speed) {
  constexpr double turns_within = 0.35;  // [s]
  NhTurn turn;
  turn.omega = std::clamp(angle / turns_within, -limits.omega_limit(), limits.omega_limit());
  const double half = 0.5 * angle, lasts = std::abs(angle) < 1e-9 ? turns_within : angle / turn.omega;
  const double best = std::abs(half) < 1e-6 ? speed : speed * half / core::math::tan(half);
  turn.v = std::clamp(best, 0.0, limits.v_limit(turn.omega));
  const double along = std::abs(angle) < 1e-6 ? 1.0 : core::math::sin(angle) / angle;
  const double across = std::abs(angle) < 1e-6 ? 0.0 : (1.0 - core::math::cos(angle)) / angle;
  turn.error = lasts * core::math::hypot(speed - turn.v * along, turn.v * across);
  return turn;
}

class NhOrca final : public SwapMethod {
 public:
  NhOrca(const core::CommandLimits& limits, HalfArena arena) : limits_(limits), arena_(arena) {}

  void step(std::span<const core::Pose> poses, std::span<const core::Pose> places, double dt,
            std::span<core::Twist> commands) override {
    const std::size_t n = poses.size();
    velocities_.resize(n);
    errors_.assign(n, most_error);
    for (std::size_t i = 0; i < n; ++i) velocities_[i] = commands[i].v * ahead(poses[i]);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (j != i) errors_[i] = std::clamp(0.5 * (core::distance(poses[i], poses[j]) - kept), least_error, errors_[i]);
    for (std::size_t i = 0; i < n; ++i) {
      constrain(i, poses, dt);
      const Vector2d chosen = choose(i, poses[i], wanted(poses[i], places[i]));
      const double speed = chosen.norm();
      const double angle =
          speed < 1e-4 ? 0.0 : core::wrap_angle(core::math::atan2(chosen.y(), chosen.x()) - poses[i].theta);
      const NhTurn turn = nh_turn(limits_, angle, speed);
      commands[i] = {turn.v, turn.omega};
    }
  }

 private:
  static constexpr double most_error = 0.02, least_error = 0.002;  // [m]
  static constexpr double horizon = 4.0;                           // [s]
  static constexpr double sees = 0.9;                              // [m]

  struct Line {
    Vector2d point, direction;  // allowed: to the left of it
    double violation(const Vector2d& v) const { return cross(direction, point - v); }
  };

  Vector2d wanted(const core::Pose& pose, const core::Pose& place) {
    const Vector2d way = at(place) - at(pose);
    const double left = way.norm();
    if (left < 1e-3) return Vector2d::Zero();
    const Vector2d v = std::min(limits_.v_max, 2.0 * left) / left * way;
    return left < 0.02 ? v : Vector2d(v + 1e-3 * Vector2d(random_.gaussian(), random_.gaussian()));  // no symmetry
  }

  void constrain(std::size_t i, std::span<const core::Pose> poses, double dt) {
    lines_.clear();
    for (std::size_t j = 0; j < poses.size(); ++j) {
      const Vector2d to = at(poses[j]) - at(poses[i]);
      if (j == i || to.norm() > sees) continue;
      const double radius = kept + errors_[i] + errors_[j];
      const Vector2d relative = velocities_[i] - velocities_[j];
      const bool apart = to.norm() > radius;
      const double inverse = 1.0 / (apart ? horizon : dt);
      const Vector2d w = relative - inverse * to;
      Line line;
      Vector2d change;
      if (!apart || (w.dot(to) < 0.0 && core::math::squared(w.dot(to)) > radius * radius * w.squaredNorm())) {
        const Vector2d unit = w.norm() > 1e-12 ? Vector2d(w.normalized()) : Vector2d(-to.normalized());
        line.direction = {unit.y(), -unit.x()};
        change = (radius * inverse - w.norm()) * unit;
      } else {
        const double leg = std::sqrt(to.squaredNorm() - radius * radius);
        if (cross(to, w) > 0.0)
          line.direction = Vector2d(to.x() * leg - to.y() * radius, to.x() * radius + to.y() * leg);
        else
          line.direction = -Vector2d(to.x() * leg + to.y() * radius, -to.x() * radius + to.y() * leg);
        line.direction /= to.squaredNorm();
        change = relative.dot(line.direction) * line.direction - relative;
      }
      line.point = velocities_[i] + 0.5 * change;
      lines_.push_back(line);
    }
    constexpr double edge_horizon = 0.5;  // [s]
    const double w = arena_.width - 0.5 * kept, h = arena_.height - 0.5 * kept;
    const auto wall = [&](const Vector2d& inwards, double room) {
      lines_.push_back({-std::max(0.0, room) / edge_horizon * inwards, {inwards.y(), -inwards.x()}});
    };
    wall({-1.0, 0.0}, w - poses[i].x), wall({1.0, 0.0}, w + poses[i].x);
    wall({0.0, -1.0}, h - poses[i].y), wall({0.0, 1.0}, h + poses[i].y);
  }

  /// The velocity nearest to the wanted one that all lines allow and the wheels can follow; where there is none, the
  /// one that is least on the wrong side of a line. Its candidates: the wanted one, the nearest of each line, where two
  /// lines cross, and a grid of what the wheels can follow.
  Vector2d choose(std::size_t i, const core::Pose& pose, const Vector2d& want) {
    Vector2d best = Vector2d::Zero();
    double least = INFINITY;
    const auto judge = [&](const Vector2d& v) {
      double violation = 0.0;
      for (const Line& line : lines_) violation = std::max(violation, line.violation(v));
      const double score = 1e3 * std::max(0.0, violation - 1e-6) + (v - want).norm();
      if (score < least) least = score, best = v;
    };
    const auto follows = [&](const Vector2d& v) {
      const double speed = v.norm();
      if (speed > limits_.v_max + 1e-9) return false;
      const double angle = speed < 1e-6 ? 0.0 : core::wrap_angle(core::math::atan2(v.y(), v.x()) - pose.theta);
      return nh_turn(limits_, angle, speed).error <= errors_[i];
    };
    const auto consider = [&](const Vector2d& v) {
      if (follows(v)) judge(v);
    };
    judge(Vector2d::Zero());
    consider(want);
    for (std::size_t a = 0; a < lines_.size(); ++a) {
      const Line& line = lines_[a];
      consider(line.point + line.direction.dot(want - line.point) * line.direction);
      for (std::size_t b = a + 1; b < lines_.size(); ++b) {
        const double sine = cross(line.direction, lines_[b].direction);
        if (std::abs(sine) < 1e-6) continue;
        consider(line.point + cross(lines_[b].direction, line.point - lines_[b].point) / sine * line.direction);
      }
    }
    constexpr int directions = 48, speeds = 6;
    for (int k = 0; k < directions; ++k) {
      const double angle = 2.0 * core::pi * (k + 0.5) / directions - core::pi;
      double low = 0.0, high = limits_.v_max;  // the most that the wheels follow
      if (nh_turn(limits_, angle, high).error > errors_[i])
        for (int step = 0; step < 12; ++step) {
          const double middle = 0.5 * (low + high);
          (nh_turn(limits_, angle, middle).error > errors_[i] ? high : low) = middle;
        }
      else
        low = high;
      const Vector2d direction(core::math::cos(pose.theta + angle), core::math::sin(pose.theta + angle));
      for (int s = 1; s <= speeds; ++s) judge(low * s / speeds * direction);
    }
    return best;
  }

  core::CommandLimits limits_;
  HalfArena arena_;
  std::vector<Vector2d> velocities_;
  std::vector<double> errors_;
  std::vector<Line> lines_;
  core::Random random_{1, 0};
};

class BarrierCertificates final : public SwapMethod {
 public:
  BarrierCertificates(const core::CommandLimits& limits, HalfArena arena) : limits_(limits), arena_(arena) {}

  void step(std::span<const core::Pose> poses, std::span<const core::Pose> places, double dt,
            std::span<core::Twist> commands) override {
    const std::size_t n = poses.size();
    points_.resize(n), velocities_.resize(n), stands_for_.resize(n, 0.0), turned_for_.resize(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      points_[i] = at(poses[i]) + point_ahead * ahead(poses[i]);
      const Vector2d way = at(places[i]) - at(poses[i]);
      const double left = way.norm();
      velocities_[i] = left < 1e-3 ? Vector2d(0.0, 0.0) : Vector2d(std::min(limits_.v_max, left) / left * way);
      if (turned_for_[i] > 0.0) {
        turned_for_[i] -= dt;
        velocities_[i] = limits_.v_max * Vector2d(velocities_[i].y(), -velocities_[i].x()).normalized();
      }
    }
    const std::vector<Vector2d> wanted = velocities_;
    certify(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vector2d u = velocities_[i], forwards = ahead(poses[i]);
      core::Twist twist{forwards.dot(u), cross(forwards, u) / point_ahead};
      const double over = std::max({1.0, std::abs(twist.v) / limits_.v_max, std::abs(twist.omega) / limits_.omega_max});
      commands[i] = {twist.v / over, twist.omega / over};
      const bool stands = u.norm() < 0.1 * wanted[i].norm() && core::distance(poses[i], places[i]) > 0.01;
      stands_for_[i] = stands ? stands_for_[i] + dt : 0.0;
      if (stands_for_[i] > patience && turned_for_[i] <= 0.0) turned_for_[i] = turned, stands_for_[i] = 0.0;
    }
  }

 private:
  // The point must not keep robots apart that stand 12 cm from one another, as places may be.
  static constexpr double point_ahead = 0.01, apart = kept + 2.0 * point_ahead;  // [m]
  static constexpr double gain = 480.0;     // the Robotarium's 100, for robots and speeds of this size [1/(m^4 s)]
  static constexpr double wall_gain = 4.0;  // [1/s]
  static constexpr double patience = 0.5, turned = 1.5;  // [s]
  static constexpr int sweeps = 300;

  struct Barrier {
    std::size_t i, j;  // j = i: an edge of the arena
    Vector2d normal;   // normal . (u_i - u_j) >= bound
    double bound, multiplier;
  };

  void certify(std::size_t n) {
    barriers_.clear();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        const Vector2d from = points_[i] - points_[j];
        const double h = from.squaredNorm() - apart * apart;
        const double bound = -gain * h * h * h;
        if (bound < -4.0 * limits_.v_max * from.norm()) continue;  // nobody closes in so fast
        barriers_.push_back({i, j, 2.0 * from, bound, 0.0});
      }
      const double w = arena_.width - 0.5 * kept - point_ahead, h = arena_.height - 0.5 * kept - point_ahead;
      const auto wall = [&](const Vector2d& inwards, double room) {
        barriers_.push_back({i, i, inwards, -wall_gain * room, 0.0});
      };
      wall({-1.0, 0.0}, w - points_[i].x()), wall({1.0, 0.0}, w + points_[i].x());
      wall({0.0, -1.0}, h - points_[i].y()), wall({0.0, 1.0}, h + points_[i].y());
    }
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      double change = 0.0;
      for (Barrier& b : barriers_) {
        Vector2d relative = velocities_[b.i];
        if (b.j != b.i) relative -= velocities_[b.j];
        const double scale = (b.j == b.i ? 1.0 : 2.0) * b.normal.squaredNorm();
        const double multiplier = std::max(0.0, b.multiplier + (b.bound - b.normal.dot(relative)) / scale);
        const Vector2d by = (multiplier - b.multiplier) * b.normal;
        b.multiplier = multiplier;
        velocities_[b.i] += by;
        if (b.j != b.i) velocities_[b.j] -= by;
        change = std::max(change, by.norm());
      }
      if (change < 1e-7) break;
    }
  }

  core::CommandLimits limits_;
  HalfArena arena_;
  std::vector<Vector2d> points_, velocities_;
  std::vector<double> stands_for_, turned_for_;
  std::vector<Barrier> barriers_;
};

}  // namespace

std::unique_ptr<SwapMethod> make_nh_orca(const core::CommandLimits& limits, HalfArena arena) {
  return std::make_unique<NhOrca>(limits, arena);
}

std::unique_ptr<SwapMethod> make_barrier_certificates(const core::CommandLimits& limits, HalfArena arena) {
  return std::make_unique<BarrierCertificates>(limits, arena);
}

double nh_orca_error(const core::CommandLimits& limits, double angle, double speed) {
  return nh_turn(limits, angle, speed).error;
}

}  // namespace skein::app
