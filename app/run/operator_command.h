#pragma once

#include <cstddef>
#include <optional>
#include <type_traits>
#include <variant>

#include "app/run/event.h"
#include "core/avoidance/obstacle.h"
#include "core/control/gain_schedule.h"

namespace skein::app {

/// Commands of the operator, or of the program, to the next tick: one small struct each. Robots and obstacles count
/// from 0.
namespace commands {

struct Start {};
struct Pause {};
struct Resume {};
struct Stage {};  ///< robots drive to their starts
struct SetGain {  ///< for all pairs
  core::GainName gain = core::GainName::k_xx;
  double value = 0.0;
  double seconds = 0.0;  ///< duration of the ramp; 0: as fast as is safe [s]
};
struct SetPairGain {  ///< for robots i and j only
  std::size_t i = 0, j = 0;
  core::GainName gain = core::GainName::k_xx;
  double value = 0.0;
  double seconds = 0.0;  ///< as of SetGain [s]
};
struct SetParameter {  ///< of the law, at once
  ParameterName name;
  double from = 0.0;  ///< its value until now, for a tick that does not know it
  double value = 0.0;
};
struct Couple {  ///< switches the coupling of robots i and j on, with the gains that they have, or off
  std::size_t i = 0, j = 0;
  bool on = true;
};
struct PutObstacle {
  std::size_t number = 0;
  core::Obstacle obstacle;  ///< its place from now on; radius 0: removed
};
struct Hold {  ///< the robot is held, out of the group, or released
  std::size_t robot = 0;
  bool on = true;
};

}  // namespace commands

using OperatorCommand = std::variant<commands::Start, commands::Pause, commands::Resume, commands::Stage,
                                     commands::SetGain, commands::SetPairGain, commands::SetParameter, commands::Couple,
                                     commands::PutObstacle, commands::Hold>;
static_assert(std::is_trivially_copyable_v<OperatorCommand>, "queues copy commands without allocating");

/// The command that caused an event of a run, to repeat it in another tick; none: no command caused it.
std::optional<OperatorCommand> command_of(const Event& event) noexcept;

}  // namespace skein::app
