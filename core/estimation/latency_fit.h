#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/estimation/identification.h"  // WheelKnot, SeenPose
#include "core/kinematics/differential_drive.h"

namespace skein::core {

// How much later than its frames were captured a camera's stamps are, from the headings of a robot that turned on the
// spot and the counters of its wheels. Not for the tick: these allocate.

/// A turn on the spot, as its wheels and a camera tell it.
struct TurnRecord {
  DifferentialDrive believed;
  std::vector<WheelKnot> wheels;  ///< their counters, in the order of the times at which they were read
  std::vector<SeenPose> poses;    ///< in the order of their times

  double turned() const;  ///< in either direction, by the counters [rad]
};

struct LatencyFit {
  static constexpr std::size_t least_poses = 50;
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  double late = none;                        ///< [s]
  double sigma = none;                       ///< standard deviation of `late`, by the noise [s]
  std::array<double, 2> halves{none, none};  ///< `late` from each half of the turn alone [s]
  double scale = none;        ///< turned as the camera saw it, over what the counters say with the believed wheels
  double heading_rms = none;  ///< of the residuals [rad]
};

/// The least-squares fit of delay and scale, and of an offset that drifts as wheels slip (linear between knots 2.5 s
/// apart), of the headings to what the counters say. core::identify with counters for commands would tell the delay,
/// too; but ten parameters of which a turn on the spot determines four converge too slowly for its search. `none` from
/// less than `least_poses` poses, or without counters.
LatencyFit fit_latency(const TurnRecord& turn);

}  // namespace skein::core
