#pragma once

namespace skein::core {

/// A step from 0 to `height` within `duration`, its slope 0 at both ends (3 w^2 - 2 w^3), and its integral over time.
struct SmoothStep {
  double height = 0.0;
  double duration = 0.0;  ///< [s]

  double at(double t) const noexcept;
  double integral(double t) const noexcept;
  /// The steepest slope of a step of this height and duration is 1.5 height / duration.
  static constexpr double steepest = 1.5;
};

/// Motion from rest to rest: accelerate to `speed`, hold it, come to rest, with a continuous, bounded acceleration. If
/// the distance is too short for the speed, the speed is lower.
class Travel {
 public:
  /// distance >= 0 [m], speed > 0 [m/s], acceleration > 0 [m/s^2].
  Travel(double distance, double speed, double acceleration) noexcept;
  /// With the speed for which it takes `duration` [s]. Requires at least `shortest(distance, acceleration)`.
  static Travel within(double distance, double duration, double acceleration) noexcept;
  /// The time of the fastest motion that the acceleration allows. [s]
  static double shortest(double distance, double acceleration) noexcept;

  struct State {
    double s = 0.0;  ///< [m]
    double v = 0.0;  ///< [m/s]
  };
  /// t seconds after the start; at rest before and afterwards.
  State at(double t) const noexcept;
  double duration() const noexcept { return 2.0 * up_.duration + cruise_; }
  double speed() const noexcept { return up_.height; }  ///< the largest [m/s]

 private:
  double distance_;
  SmoothStep up_;
  double cruise_ = 0.0;  // [s]
};

}  // namespace skein::core
