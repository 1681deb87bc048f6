#pragma once

#include <cstdint>
#include <string_view>

#include "core/geometry/pose.h"

namespace skein::core {

/// How a tag was found in a frame.
enum class How : std::uint8_t {
  none,       ///< no tag: the pose came directly from a simulation
  detected,   ///< seen for the first time
  tracked,    ///< found where it was predicted
  recovered,  ///< found again after it was lost
};

/// As the CSV calls it (core/words.h).
constexpr std::string_view word(How how) noexcept {
  switch (how) {
    case How::none:
      return "";
    case How::detected:
      return "detected";
    case How::tracked:
      return "tracked";
    case How::recovered:
      return "recovered";
  }
  return {};
}

/// The newest measured pose of one robot, from a camera or a simulation.
struct Measurement {
  static constexpr double never = -1e9;  ///< captured_at of a robot that was never seen [s]

  Pose pose;                   ///< in the world frame
  double captured_at = never;  ///< time at which the robot was there, on the session's monotonic clock [s]
  double sigma_xy = 0.0;       ///< standard deviation of x, and of y [m]
  double sigma_theta = 0.0;    ///< of theta [rad]
  How how = How::none;

  bool ever_seen() const noexcept { return captured_at > never; }
};

}  // namespace skein::core
