#include "core/estimation/camera_watch.h"

#include <algorithm>
#include <cmath>

#include "core/math/elementary.h"

namespace skein::core {
namespace {

constexpr double smallest = 0.006;    // a bump that is looked for: a fifth of a degree at 1.8 m [m]
constexpr double unlikely = 4.0;      // standard deviations that noise alone does not reach
constexpr double patience = 2.0;      // for tags that the bump has hidden [s]
constexpr double slack = 0.003;       // of a rigid motion of the plane [m], and
constexpr double perspective = 0.15;  // what tilt makes of it at the borders of a picture, a share of the motion

}  // namespace

bool CameraWatch::Robot::displaced() const noexcept {
  return math::hypot(change.x, change.y) > smallest + doubt.way + doubt.noise ||
         lever * std::abs(change.theta) > smallest + doubt.turn + doubt.noise;
}

bool CameraWatch::counts(const Robot& robot) const noexcept {
  return robot.sights >= 2 && robot.seen_at > began_at_;
}

void CameraWatch::forget() noexcept {
  suspects_ = false;
  for (Robot& robot : robots_) robot = {};
}

void CameraWatch::see(std::size_t robot, const PoseFilter& filter, const FilterParameters& parameters,
                      const Measurement& before, const Measurement& m) noexcept {
  if (m.captured_at <= robots_[robot].seen_at) return;
  // By then it has been elsewhere, under another camera or in a hand.
  if (!(m.captured_at - before.captured_at <= patience) || !filter.remembers(before.captured_at))
    return see(robot, m.pose, m.pose, m.captured_at, {});
  const Predictor::Way way = filter.way(before.captured_at, m.captured_at);
  const double drift = way.driven * math::hypot(before.sigma_theta, parameters.slip);
  const double noise = math::hypot(before.sigma_xy, drift, m.sigma_xy);
  const double turn_noise = lever * math::hypot(before.sigma_theta, m.sigma_theta);
  see(robot, filter.predict(before, m.captured_at), m.pose, m.captured_at,
      {way.driven, lever * way.turned, unlikely * std::max(noise, turn_noise)});
}

void CameraWatch::see(std::size_t robot, const Pose& expected, const Pose& measured, double captured_at,
                      const Doubt& doubt) noexcept {
  Robot& r = robots_[robot];
  if (captured_at <= r.seen_at) return;
  const double before = r.seen_at;
  r.seen_at = captured_at;
  newest_ = std::max(newest_, captured_at);
  if (captured_at < r.excused_until) {
    r.sights = 0;
    return;
  }
  const Pose step{measured.x - expected.x, measured.y - expected.y, wrap_angle(measured.theta - expected.theta)};
  r.measured = measured;
  if (suspects_ && r.sights > 0) {
    r.change = {r.change.x + step.x, r.change.y + step.y, wrap_angle(r.change.theta + step.theta)};
    r.doubt = {r.doubt.way + doubt.way, r.doubt.turn + doubt.turn, std::max(r.doubt.noise, doubt.noise)};
    ++r.sights;
    return;
  }
  r.change = step;
  r.doubt = doubt;
  r.sights = 1;
  if (suspects_ || !r.displaced()) return;
  suspects_ = true;
  since_ = before;
  began_at_ = captured_at;
  for (Robot& other : robots_)
    if (other.seen_at <= since_) other.sights = 0;
}

/// The motion of least squares. A heading counts as a second point, `lever` ahead of the tag.
CameraWatch::Motion CameraWatch::fit() const noexcept {
  Motion motion;
  double count = 0.0;
  for (const Robot& r : robots_) {
    if (!counts(r)) continue;
    count += 1.0;
    motion.to.x += r.measured.x, motion.to.y += r.measured.y;
    motion.from.x += r.measured.x - r.change.x, motion.from.y += r.measured.y - r.change.y;
  }
  motion.from.x /= count, motion.from.y /= count, motion.to.x /= count, motion.to.y /= count;
  double dot = 0.0, cross = 0.0;
  for (const Robot& r : robots_) {
    if (!counts(r)) continue;
    const double px = r.measured.x - r.change.x - motion.from.x, py = r.measured.y - r.change.y - motion.from.y;
    const double qx = r.measured.x - motion.to.x, qy = r.measured.y - motion.to.y;
    const auto [sin, cos] = math::sincos(r.change.theta);
    dot += px * qx + py * qy + lever * lever * cos;
    cross += px * qy - py * qx + lever * lever * sin;
  }
  motion.to.theta = math::atan2(cross, dot);
  return motion;
}

/// What the motion makes of a tag that stood there.
Pose CameraWatch::Motion::change_at(const Pose& before) const noexcept {
  const double x = before.x - from.x, y = before.y - from.y, c = math::cos(to.theta), s = math::sin(to.theta);
  return {c * x - s * y + to.x - before.x, s * x + c * y + to.y - before.y, to.theta};
}

bool CameraWatch::explains(const Motion& motion, const Robot& robot) const noexcept {
  const Pose change = motion.change_at({robot.measured.x - robot.change.x, robot.measured.y - robot.change.y, 0.0});
  const double way = math::hypot(robot.change.x - change.x, robot.change.y - change.y);
  const double turn = lever * std::abs(wrap_angle(robot.change.theta - change.theta));
  const double allowed = slack + robot.doubt.noise;
  return way <= allowed + perspective * math::hypot(change.x, change.y) &&
         turn <= allowed + perspective * lever * std::abs(change.theta);
}

std::optional<CommonMotion> CameraWatch::moved(std::size_t least) noexcept {
  if (!suspects_) return {};
  suspects_ = newest_ - began_at_ <= patience;
  std::size_t seen = 0, displaced = 0;
  for (const Robot& robot : robots_) {
    if (!counts(robot)) continue;
    ++seen;
    displaced += robot.displaced() ? 1 : 0;
  }
  if (seen < 2) return {};
  const Motion motion = fit();
  bool common = displaced > 0;
  for (const Robot& robot : robots_)
    if (counts(robot)) common = common && explains(motion, robot);
  if (!common) suspects_ = false;
  if (!suspects_ || displaced < std::max<std::size_t>(least, 2)) return {};
  suspects_ = false;
  CommonMotion result{.tags = seen, .turn = motion.to.theta};
  for (const Robot& robot : robots_)
    if (counts(robot)) result.distance += math::hypot(robot.change.x, robot.change.y) / static_cast<double>(seen);
  return result;
}

}  // namespace skein::core
