#pragma once

#include <Eigen/Core>

#include <cmath>
#include <optional>

#include "core/estimation/predictor.h"

namespace skein::core {

/// How many standard deviations a pose is trusted to be off at most.
inline constexpr double trusted_deviations = 3.0;

/// The filter's assumptions about a robot between two measurements.
struct FilterParameters {
  double slip = 0.03;    ///< standard deviation of a wheel's distance, as a share of it: slip, unequal wheels
  double kidnap = 0.02;  ///< how far beyond the robot's possible motion a pose must lie to count as carried [m]
};

/// Estimates a robot's pose from delayed measurements and the commands that were sent: an extended Kalman filter on the
/// unicycle kinematics (1), one per robot. Its state is the pose at the newest measurement's time of capture; the
/// predictor propagates it to the time at which a command acts. A measurement without uncertainty is used unchanged,
/// bit for bit.
class PoseFilter {
 public:
  /// Records that the robot drives with `twist` from time `acts_at` on. Times must not decrease. [s]
  void command(double acts_at, const Twist& twist) noexcept;

  /// Updates the state with the newest measurement; one that is not newer than the last changes nothing. Returns the
  /// expected pose if the robot has been carried elsewhere: then the filter restarts from the measurement.
  std::optional<Pose> see(const FilterParameters& parameters, const Measurement& measurement) noexcept;
  /// The same with a measurement by another camera, which need not be newer: an older one is propagated along the
  /// commands to the state's time, with an uncertainty that grows on the way.
  std::optional<Pose> fuse(const FilterParameters& parameters, const Measurement& measurement) noexcept;
  /// The expected pose if this measurement would make the filter restart; changes nothing.
  std::optional<Pose> surprise(const FilterParameters& parameters, const Measurement& measurement) const noexcept;

  /// Whether there has been a measurement; and the commanded motion from the newest one to `time`. [s]
  bool known() const noexcept { return known_; }
  Predictor::Way way_to(double time) const noexcept { return base_.way + predictor_.way(base_.at, time); }
  /// The commanded motion between two times; and the pose to which it leads from an earlier measurement. [s]
  Predictor::Way way(double from, double to) const noexcept { return predictor_.way(from, to); }
  Pose predict(const Measurement& from, double time) const noexcept { return predictor_.predict(from, time); }
  bool remembers(double time) const noexcept { return predictor_.remembers(time); }
  /// The pose at `time`; requires one measurement. [s]
  Pose predict(double time) const noexcept { return predictor_.predict(base_.pose, base_.at, time); }
  /// Standard deviation of the state: of a position in its worst direction [m], of the heading [rad].
  double sigma_xy() const noexcept;
  /// The same for a position predicted over `way` metres of commanded motion: the heading's error adds to it sideways,
  /// the wheels' slip along the path. [m]
  double sigma_after(const FilterParameters& parameters, double way) const noexcept {
    const double sigma = sigma_xy();
    return std::sqrt(sigma * sigma + way * way * (covariance_(2, 2) + parameters.slip * parameters.slip));
  }
  /// Of the state, of x, y, theta in the world frame [m, rad].
  const Eigen::Matrix3d& covariance() const noexcept { return covariance_; }
  double sigma_theta() const noexcept { return std::sqrt(covariance_(2, 2)); }

  /// The robot is known to have been moved by hand at this time: a jump within half a second is expected.
  void displaced(double time) noexcept { displaced_at_ = time; }
  /// The next measurement is used unchanged, and is not a kidnap.
  void forget() noexcept { known_ = false; }

 private:
  void restart(const Pose& pose, double captured_at) noexcept;
  void propagate(const FilterParameters& parameters, double time) noexcept;
  void begin(const Measurement& measurement) noexcept;
  Measurement carried(const FilterParameters& parameters, const Measurement& measurement) const noexcept;
  bool explains(const FilterParameters& parameters, const Predictor::Way& way, const Measurement& m) const noexcept;
  bool announced(const Measurement& m) const noexcept;
  std::optional<Pose> update(const FilterParameters& parameters, const Predictor::Way& way,
                             const Measurement& measurement) noexcept;

  Predictor predictor_;
  bool known_ = false;
  Pose pose_;
  double captured_at_ = 0.0;
  double displaced_at_ = -1e9;
  // The state, propagated along the commands that the predictor has dropped since: a robot may stay unseen for longer
  // than it remembers.
  struct Base {
    Pose pose;
    double at = 0.0;
    Predictor::Way way;
  } base_;
  Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();  // of x, y, theta in the world frame [m, rad]
};

}  // namespace skein::core
