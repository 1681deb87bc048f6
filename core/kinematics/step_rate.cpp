#include "core/kinematics/step_rate.h"

#include <algorithm>

namespace skein::core {
namespace {

double timer_rate(MotorModel motor) noexcept {
  switch (motor) {
    case MotorModel::epuck2:
      return 50000.0;
    case MotorModel::epuck1:
    case MotorModel::servo:
    case MotorModel::ideal:
      break;
  }
  return 10000.0;
}

}  // namespace

double max_step_rate(MotorModel motor) noexcept {
  switch (motor) {
    case MotorModel::epuck2:
      return 1100.0;
    case MotorModel::servo:  // bounded by what the robot's type allows
      return 32767.0;
    case MotorModel::epuck1:
    case MotorModel::ideal:
      break;
  }
  return 1000.0;
}

double actual_step_rate(MotorModel motor, double commanded) noexcept {
  const double limit = max_step_rate(motor);
  const double clamped = std::clamp(commanded, -limit, limit);
  if (motor == MotorModel::ideal || motor == MotorModel::servo || clamped == 0.0) return clamped;
  const double timer = timer_rate(motor);
  return std::copysign(timer / std::floor(timer / std::abs(clamped)), clamped);
}

double nearest_command(MotorModel motor, double wanted) noexcept {
  const double limit = max_step_rate(motor);
  const double clamped = std::clamp(wanted, -limit, limit);
  if (motor == MotorModel::ideal) return clamped;
  if (motor == MotorModel::servo) return std::round(clamped);
  const double size = std::abs(clamped);
  if (size < slowest_command)
    return size < 0.5 * actual_step_rate(motor, slowest_command) ? 0.0 : std::copysign(slowest_command, clamped);
  // The rates on either side of `size` are timer/k and timer/(k+1); the smallest whole command that runs timer/k is
  // ceil(timer/(k+1) + a little), and every whole command in between gives timer/k as well: take the one nearest to it.
  const double timer = timer_rate(motor);
  const double k = std::max(std::floor(timer / size), std::floor(timer / limit));
  const double faster = std::min(std::floor(timer / k), limit);
  const double slower = std::floor(timer / (k + 1.0));
  const auto miss = [&](double command) { return std::abs(std::abs(actual_step_rate(motor, command)) - size); };
  double best = std::max(std::round(size), slowest_command);
  for (const double command : {faster, slower})
    if (command >= slowest_command && miss(command) < miss(best)) best = command;
  return std::copysign(best, clamped);
}

}  // namespace skein::core
