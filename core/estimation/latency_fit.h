#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/estimation/identification.h"  // WheelKnot, SeenPose
#include "core/kinematics/differential_drive.h"

namespace skein::core {

// How late a camera's time stamps are (time stamp minus true capture time), from the headings and the wheel counters of
// a robot that turned on the spot. Not for the tick: these allocate.

/// A turn on the spot, recorded by the robot's wheel counters and by a camera.
struct TurnRecord {
  DifferentialDrive believed;
  std::vector<WheelKnot> wheels;  ///< the wheel counters, in the order in which they were read
  std::vector<SeenPose> poses;    ///< in the order of their times

  double turned() const;  ///< in either direction, by the counters [rad]
};

struct LatencyFit {
  static constexpr std::size_t least_poses = 50;
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double late = none;                        ///< [s]
  double sigma = none;                       ///< standard deviation of `late`, by the noise [s]
  std::array<double, 2> halves{none, none};  ///< `late` from each half of the turn alone [s]
  double scale = none;        ///< the rotation that the camera saw, over that of the counters with the assumed wheels
  double heading_rms = none;  ///< of the residuals [rad]
};

/// The least-squares fit of delay and scale, and of an offset that drifts as wheels slip (linear between knots 2.5 s
/// apart), of the headings to the counters. core::identify, given counters instead of commands, finds the delay as
/// well; but a turn on the spot determines only four of its ten parameters, and its search converges too slowly. `none`
/// with fewer than `least_poses` poses, or without counters.
LatencyFit fit_latency(const TurnRecord& turn);

}  // namespace skein::core
