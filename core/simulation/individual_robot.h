#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "core/estimation/identification.h"
#include "core/estimation/measurement.h"
#include "core/kinematics/differential_drive.h"
#include "core/kinematics/step_motor.h"
#include "core/simulation/random.h"

namespace skein::core {

/// The deviations of one robot, and of its camera, from the nominal ones.
struct Individual {
  DifferentialDrive wheels;
  double actuation_delay = 0.0;  ///< from a command to its arrival at the motors [s]
  double camera_delay = 0.0;     ///< lateness of the camera's time stamps [s]
  double slip = 0.0;             ///< standard deviation of each wheel's distance in a step, as a share of it
  double tag_heading = 0.0, tag_ahead = 0.0, tag_left = 0.0;  ///< of the tag, from the axle's midpoint [rad, m, m]
  double pose_noise = 0.0;                                    ///< standard deviation of a measured x, and of y [m]
  double heading_noise = 0.0;                                 ///< [rad]
  double dropout = 0.0;                                       ///< share of poses that are lost
};

/// A random robot and camera with realistic deviations.
Individual random_individual(std::uint64_t seed);
/// The true values that `identify` must find.
double truth_of(const Individual& individual, Unknown unknown) noexcept;

/// Such a robot on the floor, for studies of identification (core/estimation/identification.h). Not for the tick. The
/// same seed and the same calls give the same bits.
class IndividualRobot {
 public:
  IndividualRobot(const Individual& individual, MotorModel motor, std::uint64_t seed);

  void place(const Pose& pose) noexcept { pose_ = pose; }
  const Pose& pose() const noexcept { return pose_; }
  double now() const noexcept { return now_; }

  /// A command given now; acts after the actuation delay. [steps/s]
  void command(const WheelSpeeds& speeds);
  /// Drives for dt seconds, slipping by one draw.
  void step(double dt);
  /// The camera's measurement now; none: not seen. `captured_at` is wrong by the camera delay.
  std::optional<Measurement> see();

 private:
  void roll(double dt, double left_share, double right_share) noexcept;

  struct Pending {
    double due;
    WheelSpeeds speeds;
  };
  Individual individual_;
  Random slip_random_, camera_random_;
  StepMotor left_, right_;
  Pose pose_;
  double now_ = 0.0;
  std::deque<Pending> pending_;
};

}  // namespace skein::core
