#include "core/reference/trajectory.h"

#include <algorithm>
#include <cmath>

namespace skein::core {
namespace {

/// Turning on the spot begins this gently. [rad/s^2]
constexpr double turn_acceleration = 1.0;

}  // namespace

ReferencePoint Rounds::at(double t) const noexcept {
  const PathPoint point = path_->at(start_ + speed_ * t);
  return {point.pose, {speed_, speed_ * point.curvature}};
}

ReferenceDemand Rounds::demand(double k_y) const noexcept {
  return {speed_, speed_ * (path_->largest_curvature() + k_y)};
}

Drive::Drive(std::shared_ptr<const Path> path, double start, double t0, const Travel& travel, double turn_rate) noexcept
    : path_(std::move(path)),
      start_(start),
      t0_(t0),
      travel_(travel),
      turn_{turn_rate, SmoothStep::steepest * std::abs(turn_rate) / turn_acceleration} {}

ReferencePoint Drive::at(double t) const noexcept {
  const Travel::State travel = travel_.at(t - t0_);
  const PathPoint point = path_->at(start_ + travel.s);
  ReferencePoint reference{point.pose, {travel.v, travel.v * point.curvature}};
  const double parked = t - t0_ - travel_.duration();
  if (parked > 0.0 && turn_.height != 0.0) {
    reference.pose.theta = wrap_angle(reference.pose.theta + turn_.integral(parked));
    reference.twist.omega = turn_.at(parked);
  }
  return reference;
}

ReferenceDemand Drive::demand(double k_y) const noexcept {
  const double v = travel_.speed();
  return {v, std::max(v * (path_->largest_curvature() + k_y), std::abs(turn_.height))};
}

double Drive::end() const noexcept {
  return turn_.height != 0.0 ? std::numeric_limits<double>::infinity() : t0_ + travel_.duration();
}

std::vector<Pose> Drive::line() const {
  std::vector<Pose> poses;
  const double way = travel_.at(travel_.duration()).s;
  for (std::size_t k = 0; k <= line_parts; ++k)
    poses.push_back(path_->at(start_ + way * static_cast<double>(k) / static_cast<double>(line_parts)).pose);
  return poses;
}

ReferenceDemand Independent::demand(double k_y) const noexcept {
  ReferenceDemand most;
  for (const auto& trajectory : trajectories_) {
    const ReferenceDemand one = trajectory->demand(k_y);
    most = {std::max(most.v, one.v), std::max(most.turning, one.turning)};
  }
  return most;
}

bool Independent::smooth() const noexcept {
  return std::all_of(trajectories_.begin(), trajectories_.end(), [](const auto& t) { return t->smooth(); });
}

std::vector<std::vector<Pose>> Independent::lines() const {
  std::vector<std::vector<Pose>> lines;
  lines.reserve(trajectories_.size());
  for (const auto& trajectory : trajectories_) lines.push_back(trajectory->line());
  return lines;
}

}  // namespace skein::core
