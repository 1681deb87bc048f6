#include "core/avoidance/avoidance.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double hysteresis = 1.1;         // a region once entered is this much larger
constexpr double arrived_distance = 1e-3;  // [m]: less than the camera can tell
constexpr double arrived_angle = 0.02;     // [rad]
constexpr double pushed_away = 0.01;       // from a place at rest: it drives back from there on [m]
constexpr double close_by = 0.06;          // a robot that came straight here turns along its moving place [m]
constexpr double approach = 2.0;           // how fast a straight way back ends [1/s]
constexpr double look_ahead = 3.0;         // of a detour, where the experiment says nothing else [s]
constexpr double most_ahead = 0.1;         // that a detour's heading may be of the robot's [rad]
constexpr double standing = 0.2;           // share of the top speed below which a robot stands
constexpr double precedence = 0.05;        // how much sooner each robot gives way than the robot numbered before it
constexpr double longest_wait = 5.0;       // that counts [s]
constexpr double progress = 0.01;          // that counts [m]
constexpr double at_its_place = 0.02;      // a robot so near to where it should be is not stuck [m]

bool at_rest(const ReferencePoint& nominal) noexcept {
  return nominal.twist == Twist{};
}

/// The sum of (31) over everything inside robot i's region; nothing inside: `inside` is false.
struct Repulsion {
  Velocity velocity;
  bool inside = false;
};

Repulsion repulsion(const AvoidanceParameters& region, const Scene& scene, std::size_t i,
                    std::span<const std::uint32_t> near, const Pose& nominal) noexcept {
  Repulsion sum;
  const Pose& pose = scene.poses[i];
  const auto add = [&](const AvoidanceParameters& a, double x_j, double y_j) {
    constexpr double outside = 1.001;  // nearly all are, and then no power is needed
    const double dx = pose.x - x_j, dy = pose.y - y_j;
    if (std::abs(dx) > outside * a.alpha || std::abs(dy) > outside * a.beta) return;
    if (!(region_level(a, dx, dy) <= 1.0)) return;  // nor where a pose is not known (NaN)
    const Velocity d = descent(a, pose.x, pose.y, nominal.x, nominal.y, x_j, y_j);
    sum.velocity = {sum.velocity.x + d.x, sum.velocity.y + d.y};
    sum.inside = true;
  };
  for (const std::uint32_t j : near) add(wider(region, scene.sizes.beyond(i, j)), scene.poses[j].x, scene.poses[j].y);
  const AvoidanceParameters alone = wider(region, scene.sizes.beyond(i));
  for (const Obstacle& obstacle : scene.obstacles) add(around(alone, obstacle), obstacle.x, obstacle.y);
  // The nearest point of each edge is an obstacle without a size; over the edge it would drive a robot farther out.
  const double edge_x = scene.half_width + standard_radius, edge_y = scene.half_height + standard_radius;
  const AvoidanceParameters at_edge = around(alone, {});
  for (const double side : {-1.0, 1.0}) {
    if (std::abs(pose.x) < edge_x) add(at_edge, side * edge_x, pose.y);
    if (std::abs(pose.y) < edge_y) add(at_edge, pose.x, side * edge_y);
  }
  return sum;
}

/// (32)-(34), bounded: the reference from the robot's last pose and the velocity that repels it.
ReferencePoint repelled(const Pose& previous, double heading, const Velocity& away, double v_max,
                        const ReferenceBounds& bounds, double dt) noexcept {
  const double speed = std::min(math::hypot(away.x, away.y), v_max);          // (32, 33)
  const double wanted = speed > 0.0 ? math::atan2(away.y, away.x) : heading;  // (34c)
  const double omega_limit = bounds.omega_limit();
  const double omega = std::clamp(wrap_angle(wanted - heading) / dt, -omega_limit, omega_limit);  // (34e), bounded
  const double theta = wrap_angle(heading + omega * dt);
  const double along = speed * std::max(0.0, math::cos(wanted - theta));
  const double v = std::min(along, bounds.v_limit(omega));  // (34d), bounded
  const auto [sin, cos] = math::sincos(theta);
  return {{previous.x + dt * v * cos, previous.y + dt * v * sin, theta}, {v, omega}};  // (34a, b)
}

/// How the modified reference moves to come back to the nominal one: the law (15) of a robot alone, inside the bounds.
Twist homing(const Gains& gains, std::size_t i, const ReferencePoint& nominal, const Pose& from,
             const ReferenceBounds& bounds) noexcept {
  const TrackingError e = tracking_error(nominal.pose, from);
  const double normaliser = std::sqrt(1.0 + gains.k * gains.k * (e.x * e.x + e.y * e.y));
  const double v = nominal.twist.v * math::cos(e.theta) + saturate(gains.saturation, bounds.v, gains.c_x[i] * e.x);
  const double omega = nominal.twist.omega + saturate(gains.saturation, bounds.omega, gains.c_theta[i] * e.theta) +
                       gains.k_y * nominal.twist.v * gains.k * e.y / normaliser * sinc(e.theta);
  const double omega_limit = bounds.omega_limit();
  const double omega_bounded = std::clamp(omega, -omega_limit, omega_limit);
  return {std::clamp(v, 0.0, bounds.v_limit(omega_bounded)), omega_bounded};
}

/// Straight to where the place is, and there into its direction.
Twist straight_home(const ReferencePoint& nominal, const Pose& from, const ReferenceBounds& bounds) noexcept {
  const double dx = nominal.pose.x - from.x, dy = nominal.pose.y - from.y;
  const double left = math::hypot(dx, dy);
  if (left < 0.7 * arrived_distance) return Steering::towards(nominal.pose.theta, 0.0, from.theta, bounds);
  const double speed = std::min(bounds.v, std::abs(nominal.twist.v) + approach * left);
  return Steering::towards(math::atan2(dy, dx), speed, from.theta, bounds);
}

}  // namespace

Avoidance::Avoidance(std::size_t robots, std::size_t obstacles)
    : robots_(robots), moves_(robots), touching_(robots), ahead_(robots), steering_(robots, obstacles) {}

/// Held up, and for a while no nearer to its place.
bool Avoidance::is_stuck(Robot& robot, double dt, bool held, double distance) const noexcept {
  const bool hindered = held || robot.state == State::avoiding;
  if (distance < robot.nearest - progress || (!hindered && robot.state == State::nominal)) {
    robot.nearest = distance;
    robot.stuck_for = 0.0;
  } else if (hindered) {
    robot.stuck_for += dt;
  }
  return robot.stuck_for > patience && distance > at_its_place;
}

void Avoidance::detour(std::size_t i, const AvoidanceParameters& parameters, const Gains& gains, double dt,
                       const Scene& scene, const ReferencePoint& nominal) noexcept {
  Robot& robot = robots_[i];
  const ReferenceBounds bounds = reference_bounds(gains, i);
  if (robot.state != State::detouring) {
    if (robot.state == State::nominal) robot.reference.pose.theta = scene.poses[i].theta;
    robot.heading = std::numeric_limits<double>::quiet_NaN();
    robot.reference.twist = {};
    robot.waited = 0.0;
    robot.left = distance(scene.poses[i], nominal.pose);
    robot.state = State::detouring;
  }
  const double horizon = parameters.horizon > 0.0 ? parameters.horizon : look_ahead;
  const double left = distance(scene.poses[i], nominal.pose);
  const bool stands = distance(scene.poses[i], robot.previous) < standing * bounds.v * dt &&
                      left > robot.left - standing * bounds.v * dt;
  robot.waited = stands ? std::min(robot.waited + dt * (1.0 + precedence * static_cast<double>(i)), longest_wait)
                        : std::max(0.0, robot.waited - 0.5 * dt);
  robot.left = left;
  // The law turns a robot after its reference only slowly: the reference waits for it.
  const Pose& pose = scene.poses[i];
  const double ahead = std::clamp(wrap_angle(robot.reference.pose.theta - pose.theta), -most_ahead, most_ahead);
  const Pose from{pose.x, pose.y, wrap_angle(pose.theta + ahead)};
  const Course course = steering_.choose(scene, {.robot = i,
                                                 .near = ahead_.around(i),
                                                 .from = from,
                                                 .goal = nominal,
                                                 .bounds = bounds,
                                                 .horizon = horizon,
                                                 .last_heading = robot.heading,
                                                 .last_omega = robot.reference.twist.omega,
                                                 .waited = robot.waited});
  robot.heading = course.heading;
  const Twist twist = Steering::towards(course.heading, course.speed, from.theta, bounds);
  const double theta = wrap_angle(from.theta + twist.omega * dt);
  // As (34a, b): from where the robot was, so that it neither runs ahead of its reference nor behind.
  robot.reference = {
      {robot.previous.x + dt * twist.v * math::cos(theta), robot.previous.y + dt * twist.v * math::sin(theta), theta},
      twist};
  if (distance(from, nominal.pose) > close_by) return;
  robot.state = State::returning;
  robot.straight = at_rest(nominal);
  robot.stuck_for = 0.0;
}

void Avoidance::come_back(std::size_t i, const Gains& gains, double dt, const ReferencePoint& nominal) noexcept {
  Robot& robot = robots_[i];
  const ReferenceBounds bounds = reference_bounds(gains, i);
  robot.reference.pose = advance(robot.reference.pose, robot.reference.twist, dt);
  const TrackingError left = tracking_error(nominal.pose, robot.reference.pose);
  const double distance = math::hypot(left.x, left.y);
  if (robot.straight && !at_rest(nominal) && distance < close_by) robot.straight = false;
  robot.reference.twist = robot.straight || at_rest(nominal) ? straight_home(nominal, robot.reference.pose, bounds)
                                                             : homing(gains, i, nominal, robot.reference.pose, bounds);
  if (distance < arrived_distance && std::abs(left.theta) < arrived_angle)
    robot.state = State::nominal;
  else
    robot.state = State::returning;
}

void Avoidance::step(const AvoidanceParameters& parameters, const Gains& gains, double dt, const Scene& scene,
                     std::span<const ReferencePoint> nominal, std::span<ReferencePoint> reference,
                     std::span<const AvoidanceParameters> own) noexcept {
  const bool looks_ahead = parameters.enabled && parameters.horizon > 0.0;
  const bool field = parameters.enabled && !looks_ahead;
  double widest = std::max(parameters.alpha, parameters.beta);
  for (const AvoidanceParameters& each : own) widest = std::max({widest, each.alpha, each.beta});
  if (field) touching_.sort(scene.poses, hysteresis * widest + 2.0 * scene.sizes.most());
  // A detour stays out of the others' regions, or they would avoid it.
  Scene spacious = scene;
  if (field) spacious.keep = std::max(scene.keep, hysteresis * widest);
  bool sorted_ahead = false;
  const auto sort_ahead = [&] {
    if (sorted_ahead) return;
    // A robot that follows its place is assumed to go on, also in the first tick, before any command was given.
    for (std::size_t j = 0; j < robots_.size(); ++j)
      moves_[j] = robots_[j].state == State::nominal && distance(scene.poses[j], nominal[j].pose) < at_its_place
                      ? nominal[j].twist
                      : scene.twists[j];
    spacious.twists = moves_;
    const double horizon = looks_ahead ? parameters.horizon : look_ahead;
    const double fastest = *std::max_element(gains.v_max.begin(), gains.v_max.end());
    ahead_.sort(scene.poses, 2.0 * fastest * horizon + spacious.keep + 2.0 * scene.sizes.most());
    sorted_ahead = true;
  };
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Robot& robot = robots_[i];
    robot.found_stuck = false;
    const Pose& pose = scene.poses[i];
    if (!robot.has_previous) robot.previous = pose;
    const bool known = !std::isnan(pose.x);

    AvoidanceParameters region = own.empty() ? parameters : own[i];
    if (robot.state == State::avoiding) region.alpha *= hysteresis, region.beta *= hysteresis;
    const Repulsion away = field ? repulsion(region, scene, i, touching_.around(i), nominal[i].pose) : Repulsion{};
    const bool held = i < scene.held.size() && scene.held[i];
    const bool stuck = parameters.enabled && known && robot.state != State::detouring &&
                       is_stuck(robot, dt, held, distance(pose, nominal[i].pose));
    bool meets = false;
    if (looks_ahead && known && robot.state != State::detouring) {
      sort_ahead();
      meets = steering_.conflict(spacious, i, ahead_.around(i), follows(i, nominal), parameters.horizon);
    }

    if (robot.state == State::detouring || stuck || meets) {
      robot.found_stuck = stuck;
      sort_ahead();
      detour(i, parameters, gains, dt, spacious, nominal[i]);
    } else if (away.inside) {
      const ReferenceBounds bounds = reference_bounds(gains, i);
      const bool goes_on = robot.state == State::avoiding;
      const double heading = goes_on ? robot.reference.pose.theta : robot.previous.theta;
      robot.reference = repelled(robot.previous, heading, away.velocity, gains.v_max[i], bounds, dt);
      robot.state = State::avoiding;
      robot.straight = false;
    } else if (robot.state != State::nominal) {
      come_back(i, gains, dt, nominal[i]);
    } else if (parameters.enabled && known && at_rest(nominal[i]) && distance(pose, nominal[i].pose) > pushed_away) {
      robot.reference = {pose, {}};
      robot.state = State::returning;
      robot.straight = true;
    }
    robot.previous = pose;
    robot.has_previous = known;
    // Noise and delay let a pose, and what is worked out from it, seem to be over the edge.
    const double x_most = scene.half_width - scene.sizes.beyond(i), y_most = scene.half_height - scene.sizes.beyond(i);
    robot.reference.pose.x = std::clamp(robot.reference.pose.x, -x_most, x_most);
    robot.reference.pose.y = std::clamp(robot.reference.pose.y, -y_most, y_most);
    reference[i] = follows(i, nominal);
  }
}

}  // namespace skein::core
