#include "core/avoidance/avoidance.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"

namespace skein::core {
namespace {

constexpr double hysteresis = 1.1;         // a region once entered is this much larger
constexpr double arrived_distance = 1e-3;  // [m]: less than the camera can tell
constexpr double arrived_angle = 0.02;     // [rad]

/// The sum of (31) over everything inside robot i's region; nothing inside: `inside` is false.
struct Repulsion {
  Velocity velocity;
  bool inside = false;
};

Repulsion repulsion(const AvoidanceParameters& region, std::size_t i, std::span<const Pose> poses,
                    std::span<const Obstacle> obstacles, const Pose& nominal) noexcept {
  Repulsion sum;
  const Pose& pose = poses[i];
  const auto add = [&](const AvoidanceParameters& a, double x_j, double y_j) {
    if (!(region_level(a, pose.x - x_j, pose.y - y_j) <= 1.0)) return;  // nor where a pose is not known (NaN)
    const Velocity d = descent(a, pose.x, pose.y, nominal.x, nominal.y, x_j, y_j);
    sum.velocity = {sum.velocity.x + d.x, sum.velocity.y + d.y};
    sum.inside = true;
  };
  for (std::size_t j = 0; j < poses.size(); ++j)
    if (j != i) add(region, poses[j].x, poses[j].y);
  for (const Obstacle& obstacle : obstacles) add(around(region, obstacle), obstacle.x, obstacle.y);
  return sum;
}

/// (32)-(34), bounded: the reference from the robot's last pose and the velocity that repels it.
ReferencePoint repelled(const Pose& previous, double heading, const Velocity& away, double v_max,
                        const ReferenceBounds& bounds, double dt) noexcept {
  const double speed = std::min(std::hypot(away.x, away.y), v_max);          // (32, 33)
  const double wanted = speed > 0.0 ? std::atan2(away.y, away.x) : heading;  // (34c)
  const double omega_limit = bounds.omega_limit();
  const double omega = std::clamp(wrap_angle(wanted - heading) / dt, -omega_limit, omega_limit);  // (34e), bounded
  const double theta = wrap_angle(heading + omega * dt);
  const double along = speed * std::max(0.0, std::cos(wanted - theta));
  const double v = std::min(along, bounds.v_limit(omega));  // (34d), bounded
  return {{previous.x + dt * v * std::cos(theta), previous.y + dt * v * std::sin(theta), theta},
          {v, omega}};  // (34a, b)
}

/// How the modified reference moves to come back to the nominal one: the law (15) of a robot alone, inside the bounds.
Twist homing(const Gains& gains, std::size_t i, const ReferencePoint& nominal, const Pose& from,
             const ReferenceBounds& bounds) noexcept {
  const TrackingError e = tracking_error(nominal.pose, from);
  const double normaliser = std::sqrt(1.0 + gains.k * gains.k * (e.x * e.x + e.y * e.y));
  const double v = nominal.twist.v * std::cos(e.theta) + saturate(gains.saturation, bounds.v, gains.c_x[i] * e.x);
  const double omega = nominal.twist.omega + saturate(gains.saturation, bounds.omega, gains.c_theta[i] * e.theta) +
                       gains.k_y * nominal.twist.v * gains.k * e.y / normaliser * sinc(e.theta);
  const double omega_limit = bounds.omega_limit();
  const double omega_bounded = std::clamp(omega, -omega_limit, omega_limit);
  return {std::clamp(v, 0.0, bounds.v_limit(omega_bounded)), omega_bounded};
}

}  // namespace

double ReferenceBounds::v_limit(double omega_ref) const noexcept {
  return std::max(0.0, std::min(v, (omega - std::abs(omega_ref)) / k_y));
}

ReferenceBounds reference_bounds(const Gains& gains, std::size_t i) noexcept {
  return {std::max(0.0, free_v(gains, i) - gains.k_xx.row_sum(i)),
          std::max(0.0, free_omega(gains, i) - gains.k_tt.row_sum(i) - gains.k_yy.row_sum(i)), gains.k_y};
}

void Avoidance::step(const AvoidanceParameters& parameters, const Gains& gains, double dt, std::span<const Pose> poses,
                     std::span<const Obstacle> obstacles, std::span<const ReferencePoint> nominal,
                     std::span<ReferencePoint> reference) noexcept {
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    const Pose previous = robot.has_previous ? robot.previous : poses[i];
    robot.previous = poses[i];
    robot.has_previous = !std::isnan(poses[i].x);

    AvoidanceParameters region = parameters;
    if (robot.state == State::avoiding) region.alpha *= hysteresis, region.beta *= hysteresis;
    const Repulsion away = parameters.enabled ? repulsion(region, i, poses, obstacles, nominal[i].pose) : Repulsion{};

    if (away.inside) {
      const ReferenceBounds bounds = reference_bounds(gains, i);
      const double heading = robot.state == State::avoiding ? robot.reference.pose.theta : previous.theta;
      robot.reference = repelled(previous, heading, away.velocity, gains.v_max[i], bounds, dt);
      robot.state = State::avoiding;
    } else if (robot.state != State::nominal) {
      robot.reference.pose = advance(robot.reference.pose, robot.reference.twist, dt);
      robot.reference.twist = homing(gains, i, nominal[i], robot.reference.pose, reference_bounds(gains, i));
      const TrackingError left = tracking_error(nominal[i].pose, robot.reference.pose);
      const bool arrived = std::hypot(left.x, left.y) < arrived_distance && std::abs(left.theta) < arrived_angle;
      robot.state = arrived ? State::nominal : State::returning;
    }
    reference[i] = robot.state == State::nominal ? nominal[i] : robot.reference;
  }
}

}  // namespace skein::core
