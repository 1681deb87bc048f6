#pragma once

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "core/avoidance/obstacle.h"
#include "core/control/gains.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// A parameter of a controller that the file can set: [controller.parameters].
struct ControllerParameter {
  std::string_view name;
  std::string_view unit;  ///< empty: none
  double low, high;       ///< both allowed
  double value;           ///< default
  std::string_view help;  ///< one line
};

/// The input of a controller at a tick. One entry per robot in each span, in the same order. World frame, SI units.
struct ControllerInput {
  double t = 0.0;   ///< time of the experiment [s]
  double dt = 0.0;  ///< since the previous tick [s]
  std::int64_t tick = 0;
  std::span<const Pose> poses;                  ///< at the time at which the command acts; NaN: never seen
  std::span<const Eigen::Matrix3d> covariance;  ///< of x, y, theta, when measured; empty: not available
  std::span<const Twist> twists;                ///< the present motion of each
  std::span<const ReferencePoint> nominal;      ///< of the formation
  std::span<const ReferencePoint> reference;    ///< after avoidance: to be tracked
  std::span<const Twist> reference_twists;      ///< the twists of `reference` alone
  std::span<const TrackingError> errors;        ///< (4), of `reference`; zero for a robot that is out
  std::span<const std::uint8_t> out;            ///< 1: lost or held, it stands and is out of the group
  std::span<const Obstacle> obstacles;          ///< present on the floor now
  const Gains* gains = nullptr;                 ///< the present parameters of (14) and (15) in [controller]; never null
  std::span<const double> parameters;           ///< in the order in which the kind declares them
};

/// The law that drives the group: called once per tick, between the reference (after avoidance) and the limits. Limits,
/// shield, edges, lost and held robots and STOP act after it, and it cannot switch them off. Part of the tick:
/// allocates in its constructor only, never blocks, never throws. Its output depends on the input only, so that a run
/// can be repeated from any tick on.
class Controller {
 public:
  virtual ~Controller() = default;
  /// Writes one command per robot into `command` [m/s, rad/s], not limited; a value that is not a number stops that
  /// robot. `log` gets the values that the kind names, all of robot 1 first. Neither overlaps the inputs.
  virtual void step(const ControllerInput& input, std::span<Twist> command, std::span<double> log) noexcept = 0;
};

}  // namespace skein::core
