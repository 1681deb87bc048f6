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

/// A number that a controller can be given by the file: [controller.parameters].
struct ControllerParameter {
  std::string_view name;
  std::string_view unit;  ///< empty: it has none
  double low, high;       ///< both allowed
  double value;           ///< unless the file says otherwise
  std::string_view help;  ///< a line of words
};

/// All that a controller knows at a tick. One entry a robot in each span, in the same order. World frame, SI units.
struct ControllerInput {
  double t = 0.0;   ///< time of the experiment [s]
  double dt = 0.0;  ///< since the tick before [s]
  std::int64_t tick = 0;
  std::span<const Pose> poses;                  ///< at the time at which the command acts; NaN: never seen
  std::span<const Eigen::Matrix3d> covariance;  ///< of x, y, theta, when measured; empty where nobody keeps it
  std::span<const Twist> twists;                ///< how each drives now
  std::span<const ReferencePoint> nominal;      ///< of the formation
  std::span<const ReferencePoint> reference;    ///< after avoidance: what is to be tracked
  std::span<const Twist> reference_twists;      ///< the twists of `reference` alone
  std::span<const TrackingError> errors;        ///< (4), of `reference`; zero for a robot that is out
  std::span<const std::uint8_t> out;            ///< 1: lost or held, it stands and counts for nobody
  std::span<const Obstacle> obstacles;          ///< that stand on the floor now
  const Gains* gains = nullptr;                 ///< what [controller] says of (14) and (15), as it is now; never null
  std::span<const double> parameters;           ///< in the order in which the kind declares them
};

/// What drives the group: asked once a tick, between the reference (after avoidance) and the limits. Limits, shield,
/// edges, lost and held robots and STOP come after it, and it cannot switch them off. Part of the tick: allocates in
/// its constructor only, never waits, never throws. Its answer depends on the input alone, so that a run can be
/// repeated from any tick on.
class Controller {
 public:
  virtual ~Controller() = default;
  /// One command a robot into `command` [m/s, rad/s], not limited; what is no number makes that robot stand.
  /// `log` gets the values that the kind names, all of robot 1 first. Neither overlaps the inputs.
  virtual void step(const ControllerInput& input, std::span<Twist> command, std::span<double> log) noexcept = 0;
};

}  // namespace skein::core
