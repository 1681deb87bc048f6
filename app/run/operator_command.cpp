#include "app/run/operator_command.h"

#include <algorithm>

namespace skein::app {

std::optional<OperatorCommand> command_of(const Event& event, bool recorded) noexcept {
  using Kind = OperatorCommand::Kind;
  OperatorCommand command;
  command.gain = event.gain;
  command.value = event.values[1];
  command.seconds = event.values[2];  // of gains
  command.i = static_cast<std::size_t>(std::max(0, event.robot));
  command.j = static_cast<std::size_t>(std::max(0, event.other));
  command.number = command.i;
  command.obstacle = {event.values[0], event.values[1], event.values[2]};
  command.recorded = recorded;
  switch (event.kind) {
    case Event::Kind::start:
      command.kind = Kind::start;
      return command;
    case Event::Kind::stage:
      command.kind = Kind::stage;
      return command;
    case Event::Kind::pause:
      command.kind = Kind::pause;
      return command;
    case Event::Kind::resume:
      command.kind = Kind::resume;
      return command;
    case Event::Kind::gain:
      command.kind = Kind::gain;
      return command;
    case Event::Kind::pair_gain:
      command.kind = Kind::pair_gain;
      return command;
    case Event::Kind::couple:
      command.kind = Kind::couple;
      return command;
    case Event::Kind::uncouple:
      command.kind = Kind::uncouple;
      return command;
    case Event::Kind::hold:
      command.kind = Kind::hold;
      return command;
    case Event::Kind::release:
      command.kind = Kind::release;
      return command;
    case Event::Kind::obstacle:
      command.kind = Kind::obstacle;
      return command;
    default:
      return std::nullopt;
  }
}

}  // namespace skein::app
