#include "core/simulation/simulated_robot.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {

SimulatedRobot::SimulatedRobot(const DifferentialDrive& drive, MotorModel motor, const Imperfection& imperfection,
                               std::uint64_t seed, std::uint64_t stream)
    : drive_(drive),
      imperfection_(imperfection),
      slip_random_(seed, 2 * stream),
      sensor_random_(seed, 2 * stream + 1),
      left_(motor),
      right_(motor) {}

void SimulatedRobot::command(const WheelSpeeds& commanded) noexcept {
  if (commanded != commanded_) turn(commanded);
}

void SimulatedRobot::turn(const WheelSpeeds& commanded) noexcept {
  commanded_ = commanded;
  if (!(actuation_delay_ > 0.0)) return obey(commanded);
  told_[given_++ % in_flight] = {clock_ + actuation_delay_, commanded};
  if (given_ - heard_ > in_flight) heard_ = given_ - in_flight;
}

void SimulatedRobot::roll(double dt, double left_share, double right_share) noexcept {
  // An arc for each stretch in which neither wheel changes its rate.
  for (double left = dt; left > 0.0;) {
    const double seconds = std::min({left, left_.rate_lasts(), right_.rate_lasts()});
    WheelSpeeds rolled{left_.rate(), right_.rate()};
    if (imperfection_.slip > 0.0) rolled = {rolled.left * left_share, rolled.right * right_share};
    pose_ = advance(pose_, drive_.twist(rolled), seconds);
    left_.advance(seconds);
    right_.advance(seconds);
    left = seconds < left ? left - seconds : 0.0;
  }
}

void SimulatedRobot::step(double dt) noexcept {
  double left_share = 1.0, right_share = 1.0;
  if (imperfection_.slip > 0.0) {
    left_share += imperfection_.slip * slip_random_.gaussian();
    right_share += imperfection_.slip * slip_random_.gaussian();
  }
  double rolled = 0.0;
  for (; heard_ < given_ && told_[heard_ % in_flight].due <= clock_ + dt; ++heard_) {
    const Told& told = told_[heard_ % in_flight];
    const double until = std::max(rolled, told.due - clock_);
    roll(until - rolled, left_share, right_share);
    rolled = until;
    obey(told.speeds);
  }
  roll(rolled > 0.0 ? dt - rolled : dt, left_share, right_share);
  clock_ += dt;

  const double slide = math::hypot(slide_x_, slide_y_);
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
