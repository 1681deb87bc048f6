#pragma once

#include <span>

#include "app/run/operator_command.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// The inputs of a tick.
struct TickInput {
  double now = 0.0;   ///< session's clock [s]
  int elapsed = 1;    ///< ticks since the previous one: 1, or more when deadlines were missed
  bool stop = false;  ///< STOP is latched
  /// The newest of each robot; by several cameras: those of camera 1, then those of camera 2...
  std::span<const core::Measurement> measurements;
  std::span<const core::Pose> truth;  ///< of each robot, NaN where unknown
  std::span<const double> delays;     ///< from each robot's command to its wheels, as measured [s]; empty: none
  std::span<const LinkInput> links;   ///< of each robot; empty: no robot has one
  std::span<const OperatorCommand> commands;
  bool recorded = false;  ///< the commands are those of a recorded run: their values are already clamped
  /// The commands of the run's own controller, one per robot: none if invalid. Empty: it was not asked.
  std::span<const core::Twist> law;
  std::span<const double> logged;  ///< by it, as TickRecord::logged
  ControllerState controller = ControllerState::answered;
  EventList events;  ///< reported by the world: perturbations, moves, links
};

}  // namespace skein::app
