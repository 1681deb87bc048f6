#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "core/estimation/measurement.h"
#include "core/geometry/pose.h"

namespace skein::app {

/// When and where each camera has last seen each robot. The cameras' threads share it.
class LastSights {
 public:
  LastSights(std::size_t cameras, std::size_t robots) : robots_(robots), sights_(cameras * robots) {}

  /// A camera's newest measurement of a robot; one that is not newer than the last is ignored.
  void saw(std::size_t camera, std::size_t robot, const core::Measurement& newest);
  /// When any camera has last seen a robot, on the session's clock [s].
  double newest(std::size_t robot) const;
  /// Where the other cameras see a robot, carried to time t at the velocity that they saw last; empty: none has seen it
  /// within `carried_for`. [s]
  std::optional<core::Pose> elsewhere(std::size_t camera, std::size_t robot, double t) const;

  static constexpr double carried_for = 0.2;  ///< [s]

 private:
  struct Sight {
    core::Measurement measurement;
    core::Pose velocity;  // per second; zero: not known
  };
  std::size_t robots_;
  mutable std::mutex mutex_;
  std::vector<Sight> sights_;  // guarded by it: camera * robots_ + robot
};

}  // namespace skein::app
