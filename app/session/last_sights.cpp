#include "app/session/last_sights.h"

#include <algorithm>
#include <cmath>

namespace skein::app {

void LastSights::saw(std::size_t camera, std::size_t robot, const core::Measurement& newest) {
  const std::lock_guard lock(mutex_);
  auto& [before, velocity] = sights_[camera * robots_ + robot];
  const double elapsed = newest.captured_at - before.captured_at;
  if (elapsed <= 0.0) return;
  velocity = {};
  if (elapsed <= carried_for)
    velocity = {(newest.pose.x - before.pose.x) / elapsed, (newest.pose.y - before.pose.y) / elapsed,
                core::wrap_angle(newest.pose.theta - before.pose.theta) / elapsed};
  before = newest;
}

double LastSights::newest(std::size_t robot) const {
  const std::lock_guard lock(mutex_);
  double newest = core::Measurement::never;
  for (std::size_t at = robot; at < sights_.size(); at += robots_)
    newest = std::max(newest, sights_[at].measurement.captured_at);
  return newest;
}

std::optional<core::Pose> LastSights::elsewhere(std::size_t camera, std::size_t robot, double t) const {
  const std::lock_guard lock(mutex_);
  const Sight* newest = nullptr;
  for (std::size_t at = robot; at < sights_.size(); at += robots_)
    if (at != camera * robots_ + robot && std::abs(t - sights_[at].measurement.captured_at) <= carried_for &&
        (newest == nullptr || sights_[at].measurement.captured_at > newest->measurement.captured_at))
      newest = &sights_[at];
  if (newest == nullptr) return {};
  const core::Pose &pose = newest->measurement.pose, &velocity = newest->velocity;
  const double elapsed = t - newest->measurement.captured_at;
  return core::Pose{pose.x + velocity.x * elapsed, pose.y + velocity.y * elapsed,
                    core::wrap_angle(pose.theta + velocity.theta * elapsed)};
}

}  // namespace skein::app
