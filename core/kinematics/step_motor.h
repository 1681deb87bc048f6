#pragma once

#include <cstdint>

#include "core/kinematics/step_rate.h"

namespace skein::core {

/// One wheel's stepper motor and its timer, step by step, as in the robots' firmware (e-puck1 e_motors.c and
/// e_agenda.c, e-puck2 motors.c). Between two steps it turns evenly towards the next step.
///
/// - e-puck1: a timer of 10 kHz counts to floor(10000/|s|). Below 601 steps/s the coils are switched off 1.5 ms after a
///   step (power saving), in two counts: a speed command in the meantime, even of the same speed, delays the next step
///   by 1.5 ms, or by a whole step if it comes within these 1.5 ms.
/// - e-puck2: half steps, a timer of 100 kHz whose period is preloaded: a new speed waits until the current half step
///   has ended; only a change of direction and a stop act at once. A standing motor's timer runs at 100 Hz.
/// - ideal, servo: exactly the commanded rate.
class StepMotor {
 public:
  explicit StepMotor(MotorModel model) noexcept : model_(model) {}

  /// A speed command arrives now. [steps/s], clamped as by the firmware
  void command(double speed) noexcept;
  /// Lets time pass. [s]
  void advance(double dt) noexcept;

  /// The rate at which it turns now [steps/s], and for how long it keeps that rate [s]; infinity: until the next
  /// command.
  double rate() const noexcept { return rate_; }
  double rate_lasts() const noexcept;
  /// The rate of the commanded speed, once the current step has ended. [steps/s]
  double settled_rate() const noexcept { return actual_step_rate(model_, speed_); }

  /// Where the shaft is, fractions of a step included; and the counter, whole steps. [steps]
  double position() const noexcept { return position_; }
  std::int64_t counter() const noexcept;
  void set_counter(std::int64_t steps) noexcept;

 private:
  double step_size() const noexcept;
  double until_step() const noexcept;
  void fire() noexcept;
  void aim() noexcept;

  MotorModel model_;
  double speed_ = 0.0;  // commanded and clamped
  double rate_ = 0.0;
  double position_ = 0.0;
  double landed_ = 0.0;    // position after the newest step or half step
  double elapsed_ = 0.0;   // the timer, since its last reset [s]
  double period_ = 0.01;   // its period [s]
  bool coils_on_ = false;  // e-puck1: the power saving's first count runs
  bool settled_ = true;    // the current step began at the commanded speed, or it stands
};

/// How far one wheel rolls from one command to the next, as the tick expects it:
///
/// - e-puck2: its motor is run along. One that starts from standing makes its first half step within 10 ms whatever
///   the speed: slow wheels that start and stop in turn roll several times as far as their speeds say.
/// - e-puck1: as far as on average, since what a command costs depends on the moment at which it arrives.
class ExpectedWheel {
 public:
  explicit ExpectedWheel(MotorModel model) noexcept : model_(model), motor_(model) {}

  /// `dt` after the previous command, if there was one [s], this one takes effect [steps/s]. `sent`: a command went to
  /// the robot, for this wheel or the other. Returns the mean rate over the next `period` [steps/s, s].
  double command(double speed, bool sent, double dt, double period) noexcept;
  /// It has stood for a while.
  void forget() noexcept { *this = ExpectedWheel(model_); }

 private:
  MotorModel model_;
  bool begun_ = false;  // there was a command
  double speed_ = 0.0;  // commanded
  StepMotor motor_;
};

/// The mean loss of steps of an e-puck1 at a speed command that arrives at a random time: positive if the wheel rolls
/// less far than it would at the new rate from that time on. `from`, `to`: commanded; equal where only the other
/// wheel's speed changes, since a command goes to both. [steps]
double epuck1_steps_lost(double from, double to) noexcept;

}  // namespace skein::core
