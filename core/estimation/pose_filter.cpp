#include "core/estimation/pose_filter.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

#include "core/kinematics/differential_drive.h"
#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {
namespace {

// How a robot wanders beside what its wheels do (a nudge, an uneven floor, the camera's own drift), in a second.
constexpr double wander_xy = 0.002;    // [m]
constexpr double wander_theta = 0.02;  // [rad]

constexpr double expected_within = 0.5;  // after `displaced`; a camera's frame may have been on its way [s]
constexpr double lever = 0.035;          // a turn that moves a point so far out counts as its way [m]
constexpr double surprising = 4.0;       // standard deviations that noise alone does not reach

}  // namespace

double PoseFilter::sigma_xy() const noexcept {
  const double a = covariance_(0, 0), b = covariance_(0, 1), c = covariance_(1, 1);
  return std::sqrt(0.5 * (a + c) + math::hypot(0.5 * (a - c), b));
}

void PoseFilter::command(double acts_at, const Twist& twist) noexcept {
  if (const auto leg = predictor_.forgets_next(); known_ && leg && leg->to > base_.at) {
    const double from = std::max(leg->from, base_.at);
    base_ = {predictor_.predict(base_.pose, base_.at, leg->to), leg->to, base_.way + predictor_.way(from, leg->to)};
  }
  predictor_.command(acts_at, twist);
}

void PoseFilter::restart(const Pose& pose, double captured_at) noexcept {
  pose_ = pose;
  captured_at_ = captured_at;
  base_ = {pose, captured_at, {}};
}

void PoseFilter::begin(const Measurement& m) noexcept {
  known_ = true;
  restart(m.pose, m.captured_at);
  covariance_.setZero();
  covariance_(0, 0) = covariance_(1, 1) = m.sigma_xy * m.sigma_xy;
  covariance_(2, 2) = m.sigma_theta * m.sigma_theta;
}

std::optional<Pose> PoseFilter::see(const FilterParameters& parameters, const Measurement& m) noexcept {
  if (!known_) {
    begin(m);
    return {};
  }
  if (m.captured_at <= captured_at_) return {};

  const Predictor::Way way = way_to(m.captured_at);
  propagate(parameters, m.captured_at);
  return update(parameters, way, m);
}

std::optional<Pose> PoseFilter::fuse(const FilterParameters& parameters, const Measurement& m) noexcept {
  if (!known_ || m.captured_at > captured_at_) return see(parameters, m);
  if (base_.at > captured_at_) return {};  // of an age of which the commands are forgotten
  return update(parameters, predictor_.way(m.captured_at, captured_at_), carried(parameters, m));
}

std::optional<Pose> PoseFilter::surprise(const FilterParameters& parameters, const Measurement& m) const noexcept {
  if (!known_ || announced(m)) return {};
  PoseFilter then(*this);
  const bool late = m.captured_at <= captured_at_;
  if (late && base_.at > captured_at_) return {};
  const Predictor::Way way = late ? predictor_.way(m.captured_at, captured_at_) : way_to(m.captured_at);
  if (!late) then.propagate(parameters, m.captured_at);
  if (then.explains(parameters, way, late ? carried(parameters, m) : m)) return {};
  return then.pose_;
}

/// An older measurement at the state's time.
Measurement PoseFilter::carried(const FilterParameters& parameters, const Measurement& m) const noexcept {
  const Predictor::Way way = predictor_.way(m.captured_at, captured_at_);
  const double seconds = captured_at_ - m.captured_at;
  const double heading = parameters.slip * (std::sqrt(2.0) * way.driven / DifferentialDrive{}.track + way.turned);
  Measurement now = m;
  now.pose = predictor_.predict(m, captured_at_);
  now.captured_at = captured_at_;
  now.sigma_xy =
      std::sqrt(m.sigma_xy * m.sigma_xy + wander_xy * wander_xy * seconds +
                way.driven * way.driven * (m.sigma_theta * m.sigma_theta + parameters.slip * parameters.slip));
  now.sigma_theta =
      std::sqrt(m.sigma_theta * m.sigma_theta + wander_theta * wander_theta * seconds + heading * heading);
  return now;
}

/// No farther than it can be if it stood all the while, or slid: driven way, what is not known of either pose, and a
/// little more.
bool PoseFilter::explains(const FilterParameters& parameters, const Predictor::Way& way,
                          const Measurement& m) const noexcept {
  const double far = parameters.kidnap + way.driven + surprising * math::hypot(sigma_xy(), m.sigma_xy);
  const double turned = parameters.kidnap / lever + way.turned + surprising * math::hypot(sigma_theta(), m.sigma_theta);
  const double off = math::hypot(m.pose.x - pose_.x, m.pose.y - pose_.y);
  const double turn = std::abs(wrap_angle(m.pose.theta - pose_.theta));
  return !(off > far || turn > turned);
}

bool PoseFilter::announced(const Measurement& m) const noexcept {
  return m.captured_at >= displaced_at_ && m.captured_at < displaced_at_ + expected_within;
}

/// With a measurement at the state's time.
std::optional<Pose> PoseFilter::update(const FilterParameters& parameters, const Predictor::Way& way,
                                       const Measurement& m) noexcept {
  if (!explains(parameters, way, m)) {
    const Pose expected = pose_;
    const bool known = announced(m);
    displaced_at_ = -1e9;
    begin(m);
    return known ? std::nullopt : std::optional(expected);
  }
  const Eigen::Vector3d innovation(m.pose.x - pose_.x, m.pose.y - pose_.y, wrap_angle(m.pose.theta - pose_.theta));
  if (m.sigma_xy <= 0.0 && m.sigma_theta <= 0.0) {
    begin(m);
    return {};
  }
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();
  noise(0, 0) = noise(1, 1) = m.sigma_xy * m.sigma_xy;
  noise(2, 2) = m.sigma_theta * m.sigma_theta;
  const Eigen::Matrix3d gain = covariance_ * (covariance_ + noise).inverse();
  const Eigen::Vector3d correction = gain * innovation;
  restart({pose_.x + correction.x(), pose_.y + correction.y(), wrap_angle(pose_.theta + correction.z())}, captured_at_);
  // Joseph's form stays symmetric and positive whatever the rounding.
  const Eigen::Matrix3d rest = Eigen::Matrix3d::Identity() - gain;
  covariance_ = rest * covariance_ * rest.transpose() + gain * noise * gain.transpose();
  return {};
}

/// State and covariance to `time`, by (1) with the commands sent and wheels that roll a little more or less than
/// commanded.
void PoseFilter::propagate(const FilterParameters& parameters, double time) noexcept {
  const Predictor::Way way = way_to(time);
  const Pose before = pose_;
  const double seconds = time - captured_at_;
  restart(predict(time), time);

  // A small turn at the beginning swings the whole way: d(x, y)/d(theta) = (-(y - y0), x - x0).
  Eigen::Matrix3d swing = Eigen::Matrix3d::Identity();
  swing(0, 2) = -(pose_.y - before.y);
  swing(1, 2) = pose_.x - before.x;
  covariance_ = swing * covariance_ * swing.transpose();

  const double along = parameters.slip * way.driven / std::sqrt(2.0);  // the mean of two wheels' errors
  const double heading = parameters.slip * (std::sqrt(2.0) * way.driven / DifferentialDrive{}.track + way.turned);
  const double across = 0.5 * heading * way.driven;
  const auto [uy, ux] = math::sincos(before.theta + 0.5 * wrap_angle(pose_.theta - before.theta));
  const double a = along * along, c = across * across;
  covariance_(0, 0) += a * ux * ux + c * uy * uy + wander_xy * wander_xy * seconds;
  covariance_(0, 1) += (a - c) * ux * uy;
  covariance_(1, 0) += (a - c) * ux * uy;
  covariance_(1, 1) += a * uy * uy + c * ux * ux + wander_xy * wander_xy * seconds;
  covariance_(2, 2) += heading * heading + wander_theta * wander_theta * seconds;
}

}  // namespace skein::core
