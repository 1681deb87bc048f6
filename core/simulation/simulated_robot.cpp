#include "core/simulation/simulated_robot.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"

namespace skein::core {

SimulatedRobot::SimulatedRobot(const DifferentialDrive& drive, MotorModel motor, const Imperfection& imperfection,
                               std::uint64_t seed, std::uint64_t stream)
    : drive_(drive),
      motor_(motor),
      imperfection_(imperfection),
      slip_random_(seed, 2 * stream),
      sensor_random_(seed, 2 * stream + 1) {}

void SimulatedRobot::command(const WheelSpeeds& commanded) noexcept {
  wheels_ = {actual_step_rate(motor_, commanded.left), actual_step_rate(motor_, commanded.right)};
}

void SimulatedRobot::step(double dt) noexcept {
  WheelSpeeds rolled = wheels_;
  if (imperfection_.slip > 0.0) {
    rolled.left *= 1.0 + imperfection_.slip * slip_random_.gaussian();
    rolled.right *= 1.0 + imperfection_.slip * slip_random_.gaussian();
  }
  pose_ = advance(pose_, drive_.twist(rolled), dt);

  const double slide = std::hypot(slide_x_, slide_y_);
  if (!(slide > 0.0)) return;
  // Coulomb's friction: the speed falls at a constant rate to nothing, however the time is cut into steps.
  const double until = std::min(dt, slide / friction);
  const double seconds = until - 0.5 * friction * until * until / slide;  // at the first speed, for the same way
  pose_.x += slide_x_ * seconds;
  pose_.y += slide_y_ * seconds;
  const double left = std::max(0.0, 1.0 - friction * dt / slide);
  slide_x_ *= left;
  slide_y_ *= left;
}

Measurement SimulatedRobot::measure(double now) noexcept {
  const bool lost = imperfection_.dropout > 0.0 && sensor_random_.uniform() < imperfection_.dropout;
  Measurement taken{pose_, now, imperfection_.pose_noise, imperfection_.heading_noise};
  if (imperfection_.pose_noise > 0.0) {
    taken.pose.x += imperfection_.pose_noise * sensor_random_.gaussian();
    taken.pose.y += imperfection_.pose_noise * sensor_random_.gaussian();
  }
  if (imperfection_.heading_noise > 0.0)
    taken.pose.theta = wrap_angle(taken.pose.theta + imperfection_.heading_noise * sensor_random_.gaussian());
  if (!lost) queue_[taken_++ % in_flight] = taken;
  if (taken_ - arrived_ > in_flight) arrived_ = taken_ - in_flight;

  // A nanosecond forgives the rounding of k / rate against a latency that is a whole number of ticks.
  constexpr double rounding = 1e-9;
  while (arrived_ < taken_ && queue_[arrived_ % in_flight].captured_at + imperfection_.latency <= now + rounding)
    newest_ = queue_[arrived_++ % in_flight];
  return newest_;
}

}  // namespace skein::core
