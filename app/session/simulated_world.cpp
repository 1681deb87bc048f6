#include "app/session/simulated_world.h"

#include <algorithm>

#include "app/run/tick_record.h"

namespace skein::app {

SimulatedWorld::SimulatedWorld(const Experiment& experiment) {
  const std::unique_ptr<const core::Reference> reference = make_reference(experiment);
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const RobotSpec& spec = experiment.robots[i];
    simulated_.push_back(spec.simulated());
    robots_.emplace_back(spec.true_drive(), spec.motor, experiment.simulation, experiment.seed, i);
    if (spec.truth) robots_.back().delay_commands(spec.truth->actuation_delay);
    if (spec.truth && spec.truth->runaway) {
      const auto& [at, twist] = *spec.truth->runaway;
      runaways_.push_back({at, i, {}});
      if (twist) runaways_.back().speeds = spec.true_drive().wheels(*twist);
    }
    robots_.back().place(spec.simulated() ? spec.start.value_or(reference->at(i, 0.0).pose)
                                          : core::Pose{none, none, none});
  }
  for (std::size_t k = 0; k < experiment.cameras(); ++k)
    memory_ = std::max(memory_, experiment.camera_at(k).stamps_late);
  remember();
}

void SimulatedWorld::remember() {
  if (memory_ == 0.0) return;
  while (past_.size() > 1 && past_[1].t <= now_ - memory_) past_.pop_front();
  Moment& now = past_.emplace_back(Moment{now_, {}});
  for (const core::SimulatedRobot& robot : robots_) now.poses.push_back(robot.pose());
}

void SimulatedWorld::remember_for(double seconds) {
  const std::lock_guard lock(mutex_);
  memory_ = std::max(memory_, seconds);
  if (past_.empty()) remember();
}

void SimulatedWorld::advance_locked(double now) {
  const double dt = now - now_;
  if (dt <= 0.0) return;
  now_ = now;
  run_away(now);
  for (std::size_t i = 0; i < robots_.size(); ++i)
    if (simulated_[i]) robots_[i].step(dt);
  remember();
}

void SimulatedWorld::run_away(double now) {
  std::erase_if(runaways_, [&](const Runaway& runaway) {
    if (runaway.at > now) return false;
    robots_[runaway.robot].run_away(runaway.speeds);
    return true;
  });
}

void SimulatedWorld::go_on_from(const SimulatedWorld& other) {
  const std::scoped_lock lock(mutex_, other.mutex_);
  robots_ = other.robots_;
  runaways_ = other.runaways_;
  past_ = other.past_;
  now_ = other.now_;
}

void SimulatedWorld::advance(double now) {
  const std::lock_guard lock(mutex_);
  advance_locked(now);
}

void SimulatedWorld::command(std::size_t robot, const core::WheelSpeeds& wheels) {
  const std::lock_guard lock(mutex_);
  robots_[robot].command(wheels);
}

void SimulatedWorld::turn(std::size_t robot, double now, const core::WheelSpeeds& commanded) {
  const std::lock_guard lock(mutex_);
  advance_locked(now);
  robots_[robot].turn(commanded);
}

void SimulatedWorld::stop() {
  const std::lock_guard lock(mutex_);
  for (core::SimulatedRobot& robot : robots_) robot.turn({});
}

void SimulatedWorld::place(std::size_t robot, const core::Pose& pose) {
  const std::lock_guard lock(mutex_);
  robots_[robot].place(pose);
  remember();
}

void SimulatedWorld::kick(std::size_t robot, double vx, double vy) {
  const std::lock_guard lock(mutex_);
  robots_[robot].kick(vx, vy);
}

core::Pose SimulatedWorld::pose(std::size_t robot) const {
  const std::lock_guard lock(mutex_);
  return robots_[robot].pose();
}

void SimulatedWorld::poses(std::span<core::Pose> all) const {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < robots_.size(); ++i) all[i] = robots_[i].pose();
}

/// Wheels turn evenly between two moments: there are one at least at every command.
void SimulatedWorld::poses_at(double t, std::span<core::Pose> all) const {
  const std::lock_guard lock(mutex_);
  const auto later =
      std::upper_bound(past_.begin(), past_.end(), t, [](double at, const Moment& m) { return at < m.t; });
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (later == past_.begin() || later == past_.end()) {
      all[i] = past_.empty() ? robots_[i].pose() : (later == past_.end() ? past_.back() : past_.front()).poses[i];
      continue;
    }
    const Moment& before = *std::prev(later);
    const core::Pose &a = before.poses[i], &b = later->poses[i];
    const double share = (t - before.t) / (later->t - before.t);
    all[i] = {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
              core::wrap_angle(a.theta + share * core::wrap_angle(b.theta - a.theta))};
  }
}

core::Measurement SimulatedWorld::measure(std::size_t robot, double now) {
  const std::lock_guard lock(mutex_);
  return robots_[robot].measure(now);
}

}  // namespace skein::app
