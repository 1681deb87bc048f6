#pragma once

#include <cstdint>
#include <optional>

#include "app/run/event.h"
#include "core/avoidance/obstacle.h"
#include "core/control/gain_schedule.h"

namespace skein::app {

/// What the operator, or the program for them, asks of the next tick.
struct OperatorCommand {
  enum class Kind : std::uint8_t {
    start,
    pause,
    resume,
    gain,       ///< gain, value: for all pairs
    pair_gain,  ///< gain, value: for robots i and j
    couple,     ///< robots i and j are coupled again, with the gains they have
    uncouple,   ///< they are not coupled at all until they are again
    obstacle,   ///< number, obstacle
    hold,       ///< number: the robot stands, out of the group
    release,    ///< number: it drives on
    stage,      ///< robots drive to their starts
  };
  Kind kind = Kind::start;
  core::GainName gain = core::GainName::k_xx;
  double value = 0.0;
  std::size_t i = 0, j = 0;   ///< from 0
  bool recorded = false;      ///< of a run that is repeated: the value has been held at its border already
  std::size_t number = 0;     ///< of the obstacle, or of the robot that is held or released
  double seconds = 0.0;       ///< gain, pair_gain: the ramp shall take so long; 0: as fast as it may [s]
  core::Obstacle obstacle{};  ///< where it stands from now on; radius 0: nowhere
};

/// The command behind an event of a run, for a tick that does it again; none: no command made it. `recorded` as above.
std::optional<OperatorCommand> command_of(const Event& event, bool recorded) noexcept;

}  // namespace skein::app
