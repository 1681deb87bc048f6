#pragma once

#include <Eigen/Core>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/geometry/pose.h"
#include "core/kinematics/differential_drive.h"
#include "core/kinematics/step_motor.h"

namespace skein::core {

// Identifies a differential drive from its wheel commands and its measured poses: the wheels' diameters, the track, the
// delay from command to pose, the wheels' slip, the tag's pose on the robot, and the noise of the poses; the maximum of
// their posterior, by the innovations of an extended Kalman filter; of the noise, after the others are integrated out;
// of the others, on average over the delay. Not for the tick: these allocate.

/// The wheels' angles at one time, if they executed their commands without delay. Between two knots the wheels turn at
/// a constant rate; before the first and after the last they stand still.
struct WheelKnot {
  double t = 0.0;                  ///< [s]
  double left = 0.0, right = 0.0;  ///< [steps]
};

/// The knots of the commands as the robot's motors execute them. Times must not decrease.
class WheelLog {
 public:
  explicit WheelLog(MotorModel motor) noexcept;
  void command(double t, const WheelSpeeds& speeds);
  /// The wheels stand from `t` on; ends the record.
  std::vector<WheelKnot> finish(double t) &&;

 private:
  void advance(double t);
  StepMotor left_, right_;
  double now_ = 0.0;
  std::vector<WheelKnot> knots_;
};

/// A pose as it was measured.
struct SeenPose {
  double t = 0.0;  ///< capture time reported by the camera, on the clock of the commands [s]
  Pose pose;
  bool anew = false;  ///< not connected to the previous pose: the robot was carried
};

/// The parameters to be identified.
enum class Unknown : std::uint8_t {
  left_diameter,   ///< [m]
  right_diameter,  ///< [m]
  track,           ///< [m]
  delay,           ///< from a command's time to a pose's: actuation delay, plus the error of the pose's time [s]
  slip,            ///< standard deviation of each wheel's distance within `slip_period`, as a share of it
  tag_heading,     ///< the tag's heading on the robot [rad]
  tag_ahead,       ///< the tag's midpoint ahead of that of the axle [m]
  tag_left,        ///< and to the left of it [m]
  sigma_xy,        ///< standard deviation of a measured x, and y [m]
  sigma_theta,     ///< and of theta [rad]
};

/// As the command line calls it (core/words.h).
constexpr std::string_view word(Unknown unknown) noexcept {
  switch (unknown) {
    case Unknown::left_diameter:
      return "left_diameter";
    case Unknown::right_diameter:
      return "right_diameter";
    case Unknown::track:
      return "track";
    case Unknown::delay:
      return "delay";
    case Unknown::slip:
      return "slip";
    case Unknown::tag_heading:
      return "tag_heading";
    case Unknown::tag_ahead:
      return "tag_ahead";
    case Unknown::tag_left:
      return "tag_left";
    case Unknown::sigma_xy:
      return "sigma_xy";
    case Unknown::sigma_theta:
      return "sigma_theta";
  }
  return {};
}
inline constexpr std::size_t unknowns = 10;

struct IdentificationInput {
  DifferentialDrive believed;  ///< the initial guess; the prior is wide about it (20 %, track 30 %)
  std::vector<WheelKnot> wheels;
  std::vector<SeenPose> poses;  ///< in the order of their times
  double slip_period = 0.04;    ///< [s]
};

struct Estimate {
  double value = 0.0, low = 0.0, high = 0.0;  ///< with the limits of a 95 % interval
  /// Information in the data: 1 is complete, 0 is nothing beyond the prior (1 - posterior / prior variance).
  double told = 0.0;
  /// Whether the data determine it: the interval is narrow enough to be useful (see useful_width).
  bool known = false;
};

/// The difference between a measured pose and its prediction from the previous pose and the wheels, in the robot's
/// frame.
struct Innovation {
  double t = 0.0;
  double ahead = 0.0, left = 0.0;  ///< [m]
  double theta = 0.0;              ///< [rad]
  double normalised = 0.0;         ///< Mahalanobis distance squared: 3 on average
  bool used = true;                ///< false: an outlier, which is ignored
};

struct Identification {
  std::array<Estimate, unknowns> estimates;
  Estimate wheel_diameter;  ///< the mean of both [m]
  Estimate wheel_ratio;     ///< the right wheel's diameter over the left one's: often known far better than either
  Eigen::Matrix<double, unknowns, unknowns> correlation;  ///< of the estimates' errors
  std::vector<Innovation> innovations;
  double driven = 0.0;  ///< [m]
  double turned = 0.0;  ///< in either direction [rad]
  int iterations = 0;
  bool converged = false;  ///< false: the result is not valid

  const Estimate& operator[](Unknown unknown) const { return estimates[static_cast<std::size_t>(unknown)]; }
  DifferentialDrive drive(const DifferentialDrive& believed) const;  ///< the identified drive
};

/// The largest useful half-width of an interval: 1 % of a diameter or of the track; 20 ms of delay; for slip and noise,
/// the value itself; for the tag's pose on the robot 2 degrees and 3 mm.
double useful_width(Unknown unknown, double value) noexcept;
/// The same for the wheels' ratio: an error of 0.3 % turns an e-puck by 3 degrees over a straight metre.
inline constexpr double useful_ratio = 0.003;

/// Fewer than 20 poses, or wheels that never turned: not converged.
Identification identify(const IdentificationInput& input);

}  // namespace skein::core
