#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace skein::core {

/// Detects robots that make no progress towards their places, whatever the cause. Part of the tick: allocates in its
/// constructor only.
class ProgressWatch {
 public:
  explicit ProgressWatch(std::size_t robots) : robots_(robots) {}

  /// One tick: robot i is `distance` from its place [m] and has been driven for `dt` [s]. True once when it has made no
  /// progress for `patience`, and again only after it has made progress or has been at its place.
  bool stuck(std::size_t i, double distance, double dt) noexcept {
    Robot& robot = robots_[i];
    if (distance < at_its_place || distance < robot.nearest - progress) {
      robot = {distance, 0.0, false};
      return false;
    }
    robot.waited += dt;
    // A nanosecond: dt is a quotient, and the patience a whole number of ticks.
    if (robot.told || robot.waited < patience - 1e-9) return false;
    return robot.told = true;
  }
  /// Somebody moved robot i: restarts its time without progress.
  void restart(std::size_t i) noexcept { robots_[i] = {}; }

  static constexpr double patience = 3.0;       ///< [s]
  static constexpr double progress = 0.01;      ///< that counts [m]
  static constexpr double at_its_place = 0.02;  ///< a robot this near to its place is not stuck [m]

 private:
  struct Robot {
    double nearest = std::numeric_limits<double>::infinity();  // to its place, since it last made progress [m]
    double waited = 0.0;                                       // since then [s]
    bool told = false;
  };
  std::vector<Robot> robots_;
};

}  // namespace skein::core
