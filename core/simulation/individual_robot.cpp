#include "core/simulation/individual_robot.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

namespace skein::core {

Individual random_individual(std::uint64_t seed) {
  Random dice(seed, 777);
  const auto span = [&](double low, double high) { return low + (high - low) * dice.uniform(); };
  Individual robot;
  const double left = span(0.97, 1.03), right = span(0.97, 1.03);
  robot.wheels.set_diameters(left * robot.wheels.wheel_diameter, right * robot.wheels.wheel_diameter);
  robot.wheels.track *= span(0.97, 1.03);
  robot.actuation_delay = span(0.02, 0.1), robot.camera_delay = span(-0.02, 0.02);
  robot.slip = span(0.01, 0.05);
  robot.tag_heading = span(-0.03, 0.03), robot.tag_ahead = span(-0.003, 0.003), robot.tag_left = span(-0.003, 0.003);
  robot.pose_noise = span(3e-4, 1e-3), robot.heading_noise = span(0.003, 0.015);
  robot.dropout = 0.05;
  return robot;
}

double truth_of(const Individual& robot, Unknown unknown) noexcept {
  switch (unknown) {
    case Unknown::left_diameter:
      return robot.wheels.left_diameter();
    case Unknown::right_diameter:
      return robot.wheels.right_diameter();
    case Unknown::track:
      return robot.wheels.track;
    case Unknown::delay:
      return robot.actuation_delay + robot.camera_delay;
    case Unknown::slip:
      return robot.slip;
    case Unknown::tag_heading:
      return robot.tag_heading;
    case Unknown::tag_ahead:
      return robot.tag_ahead;
    case Unknown::tag_left:
      return robot.tag_left;
    case Unknown::sigma_xy:
      return robot.pose_noise;
    case Unknown::sigma_theta:
      return robot.heading_noise;
  }
  return 0.0;
}

IndividualRobot::IndividualRobot(const Individual& individual, MotorModel motor, std::uint64_t seed)
    : individual_(individual), slip_random_(seed, 0), camera_random_(seed, 1), left_(motor), right_(motor) {}

void IndividualRobot::command(const WheelSpeeds& speeds) {
  pending_.push_back({now_ + individual_.actuation_delay, speeds});
}

void IndividualRobot::roll(double dt, double left_share, double right_share) noexcept {
  // An arc for each stretch in which neither wheel changes its rate.
  for (double ahead = dt; ahead > 0.0;) {
    const double seconds = std::min({ahead, left_.rate_lasts(), right_.rate_lasts()});
    pose_ = advance(pose_, individual_.wheels.twist({left_.rate() * left_share, right_.rate() * right_share}), seconds);
    left_.advance(seconds);
    right_.advance(seconds);
    ahead = seconds < ahead ? ahead - seconds : 0.0;
  }
}

void IndividualRobot::step(double dt) {
  const double left_share = 1.0 + individual_.slip * slip_random_.gaussian();
  const double right_share = 1.0 + individual_.slip * slip_random_.gaussian();
  const double end = now_ + dt;
  for (; !pending_.empty() && pending_.front().due <= end; pending_.pop_front()) {
    const double due = std::max(now_, pending_.front().due);
    roll(due - now_, left_share, right_share);
    now_ = due;
    left_.command(pending_.front().speeds.left);
    right_.command(pending_.front().speeds.right);
  }
  roll(end - now_, left_share, right_share);
  now_ = end;
}

std::optional<Measurement> IndividualRobot::see() {
  const bool lost = camera_random_.uniform() < individual_.dropout;
  const auto [s, c] = math::sincos(pose_.theta);
  const double ahead = individual_.tag_ahead, left = individual_.tag_left;
  const double x = pose_.x + c * ahead - s * left + individual_.pose_noise * camera_random_.gaussian();
  const double y = pose_.y + s * ahead + c * left + individual_.pose_noise * camera_random_.gaussian();
  const double theta = pose_.theta + individual_.tag_heading + individual_.heading_noise * camera_random_.gaussian();
  if (lost) return {};
  return Measurement{
      {x, y, wrap_angle(theta)}, now_ + individual_.camera_delay, individual_.pose_noise, individual_.heading_noise};
}

}  // namespace skein::core
