#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/estimation/measurement.h"
#include "core/kinematics/differential_drive.h"
#include "core/kinematics/step_motor.h"
#include "core/simulation/random.h"

namespace skein::core {

/// How a simulated robot and its localisation differ from ideal ones. Zeros: ideal.
struct Imperfection {
  double pose_noise = 0.0;     ///< standard deviation of measured x and y [m]
  double heading_noise = 0.0;  ///< of the measured heading [rad]
  double latency = 0.0;        ///< from the capture to the arrival of the pose [s]; at most 2.5 s at 25 Hz
  double dropout = 0.0;        ///< share of measurements that are lost, 0 to 1
  double slip = 0.0;           ///< standard deviation of each wheel's distance, as a share of it, drawn in every step
};

/// A robot on the floor: wheels driven by its motor model, exact arcs, and an imperfect localisation. The same seed and
/// the same calls give the same bits.
class SimulatedRobot {
 public:
  SimulatedRobot(const DifferentialDrive& drive, MotorModel motor, const Imperfection& imperfection, std::uint64_t seed,
                 std::uint64_t stream);

  /// From now on commands reach its motors this much later [s]; at most 64 are delayed at once.
  void delay_commands(double seconds) noexcept { actuation_delay_ = seconds; }

  const Pose& pose() const noexcept { return pose_; }
  /// Moves the robot to a pose, as by hand; its wheels keep turning.
  void place(const Pose& pose) noexcept { pose_ = pose, slide_x_ = slide_y_ = 0.0; }
  /// Kicks it: it slides with this velocity [m/s, world frame] in addition to its wheels' motion, until friction stops
  /// it.
  void kick(double vx, double vy) noexcept { slide_x_ += vx, slide_y_ += vy; }
  /// Deceleration of a slide [m/s^2]: rubber on a smooth floor, a friction coefficient of 0.3.
  static constexpr double friction = 3.0;
  /// A kick is over after this time, with a margin: the hardest allowed kick is 1 m/s. [s]
  static constexpr double slides_for = 1.0;

  /// Commanded wheel speeds [steps/s]; they hold until the next command, as on a real robot. Unchanged speeds have no
  /// effect: links do not send them again.
  void command(const WheelSpeeds& commanded) noexcept;
  /// The same for a robot whose link is emulated: these are its firmware's commands to the motors, new or unchanged.
  void turn(const WheelSpeeds& commanded) noexcept;
  /// The step rates of its motors once the current steps have ended.
  WheelSpeeds wheels() const noexcept { return {left_.settled_rate(), right_.settled_rate()}; }
  /// The twist from these without slip.
  Twist twist() const noexcept { return drive_.twist(wheels()); }

  /// From now on it ignores commands: its motors keep their present speeds, or take these [steps/s].
  void run_away(const std::optional<WheelSpeeds>& speeds) noexcept {
    if (speeds) obey(*speeds);
    runs_away_ = true;
  }

  /// Drives for dt seconds.
  void step(double dt) noexcept;

  /// Takes a measurement at time `now` and returns the newest one that has arrived by then (captured at now - latency
  /// or before).
  Measurement measure(double now) noexcept;

 private:
  static constexpr std::size_t in_flight = 64;

  void obey(const WheelSpeeds& speeds) noexcept {
    if (runs_away_) return;
    left_.command(speeds.left);
    right_.command(speeds.right);
  }
  void roll(double dt, double left_share, double right_share) noexcept;

  struct Told {
    double due = 0.0;  // on the robot's own clock [s]
    WheelSpeeds speeds;
  };
  DifferentialDrive drive_;
  Imperfection imperfection_;
  Random slip_random_, sensor_random_;
  Pose pose_;
  StepMotor left_, right_;
  WheelSpeeds commanded_;
  bool runs_away_ = false;
  double actuation_delay_ = 0.0, clock_ = 0.0;  // [s]
  std::array<Told, in_flight> told_{};          // delayed commands; number k is at k % in_flight
  std::size_t given_ = 0, heard_ = 0;
  double slide_x_ = 0.0, slide_y_ = 0.0;        // of a kick [m/s]
  std::array<Measurement, in_flight> queue_{};  // delayed measurements; number k is at k % in_flight
  std::size_t taken_ = 0, arrived_ = 0;
  Measurement newest_;
};

}  // namespace skein::core
