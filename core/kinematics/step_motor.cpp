#include "core/kinematics/step_motor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace skein::core {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double epuck1_tick = 1e-4, epuck2_tick = 1e-5;  // [s]
constexpr double power_saving_below = 601.0;              // e-puck1 [steps/s]
constexpr double coils_on_for = 15.0 * epuck1_tick;       // [s]
constexpr double standing_period = 0.01;                  // e-puck2 [s]

/// It turns evenly, without steps.
bool even(MotorModel model) noexcept {
  return model == MotorModel::ideal || model == MotorModel::servo;
}

bool saves_power(double speed) noexcept {
  return std::abs(speed) < power_saving_below;
}

double epuck1_period(double speed) noexcept {
  return std::floor(10000.0 / std::abs(speed)) * epuck1_tick;
}
double epuck2_half_period(double speed) noexcept {
  return std::floor(50000.0 / std::abs(speed)) * epuck2_tick;
}

}  // namespace

void StepMotor::command(double speed) noexcept {
  const double limit = max_step_rate(model_);
  speed_ = std::clamp(speed, -limit, limit);
  switch (model_) {
    case MotorModel::ideal:
    case MotorModel::servo:
      rate_ = speed_;
      return;
    case MotorModel::epuck1:
      if (speed_ != 0.0) period_ = epuck1_period(speed_);
      break;
    case MotorModel::epuck2:  // preloaded: see step()
      break;
  }
  aim();
}

/// Of the shaft, at once. [steps]
double StepMotor::step_size() const noexcept {
  switch (model_) {
    case MotorModel::epuck2:
      return 0.5;
    case MotorModel::epuck1:
    case MotorModel::ideal:
    case MotorModel::servo:
      break;
  }
  return 1.0;
}

/// Time until the shaft makes its next step, or half step. [s]
double StepMotor::until_step() const noexcept {
  if (model_ == MotorModel::epuck2) return std::max(period_ - elapsed_, 0.0);
  const double counts = std::max(period_ - elapsed_, epuck1_tick);  // one whose count is over acts at the next tick
  return coils_on_ && saves_power(speed_) ? counts + (period_ - coils_on_for) : counts;
}

/// From where the shaft is to where it is due next.
void StepMotor::aim() noexcept {
  settled_ = speed_ == 0.0;
  if (speed_ == 0.0) {
    rate_ = 0.0;
    return;
  }
  const double target = landed_ + std::copysign(step_size(), speed_);
  rate_ = (target - position_) / std::max(until_step(), epuck2_tick);
}

/// The timer has counted to its end.
void StepMotor::fire() noexcept {
  elapsed_ = 0.0;
  switch (model_) {
    case MotorModel::ideal:
    case MotorModel::servo:
      return;
    case MotorModel::epuck1:
      if (coils_on_ && saves_power(speed_)) {
        coils_on_ = false;
        period_ = epuck1_period(speed_) - coils_on_for;
        return;
      }
      if (saves_power(speed_)) {
        coils_on_ = true;
        period_ = coils_on_for;
      }
      break;
    case MotorModel::epuck2:
      period_ = speed_ == 0.0 ? standing_period : epuck2_half_period(speed_);
      if (speed_ == 0.0) return;
      break;
  }
  landed_ += std::copysign(step_size(), speed_);
  position_ = landed_;
  rate_ = actual_step_rate(model_, speed_);
  settled_ = true;
}

double StepMotor::rate_lasts() const noexcept {
  return even(model_) || settled_ ? never : std::max(until_step(), epuck2_tick);
}

void StepMotor::advance(double dt) noexcept {
  if (even(model_)) {
    position_ += rate_ * dt;
    return;
  }
  if (speed_ == 0.0 && model_ == MotorModel::epuck1) return;  // its timer stands as well
  // Rounding must not put off a step that is due by the time that has passed.
  constexpr double rounding = 1e-9;
  while (true) {
    const double left = std::max(period_ - elapsed_, 0.0);
    if (dt + rounding < left) {
      elapsed_ += dt;
      position_ += rate_ * dt;
      return;
    }
    position_ += rate_ * left;
    dt = std::max(dt - left, 0.0);
    fire();
    if (dt == 0.0) return;
  }
}

std::int64_t StepMotor::counter() const noexcept {
  const double whole = even(model_) ? position_ : landed_;
  return static_cast<std::int64_t>(whole + std::copysign(1e-6, whole));
}

void StepMotor::set_counter(std::int64_t steps) noexcept {
  const double from = even(model_) ? position_ : landed_;
  position_ += static_cast<double>(steps) - from;
  landed_ = static_cast<double>(steps);
}

double epuck1_steps_lost(double from, double to) noexcept {
  if (to == 0.0 || from == 0.0 || !saves_power(from)) return 0.0;
  const double before = epuck1_period(from), after = epuck1_period(to);
  const double coils_on = coils_on_for / before;  // share of the time
  const double delay = (1.0 - coils_on) * coils_on_for + (saves_power(to) ? coils_on * (after - coils_on_for) : 0.0);
  return std::copysign(delay / after, to);
}

double ExpectedWheel::command(double speed, bool sent, double dt, double period) noexcept {
  const double before = speed_;
  speed_ = speed;
  switch (model_) {
    case MotorModel::ideal:
    case MotorModel::servo:
      return speed;
    case MotorModel::epuck1:
      return actual_step_rate(model_, speed) - (sent ? epuck1_steps_lost(before, speed) / period : 0.0);
    case MotorModel::epuck2:
      break;
  }
  if (std::exchange(begun_, true)) motor_.advance(std::min(dt, 1.0));  // after a longer time only its timer differs
  if (sent) motor_.command(speed);
  StepMotor ahead = motor_;
  ahead.advance(period);
  return (ahead.position() - motor_.position()) / period;
}

}  // namespace skein::core
