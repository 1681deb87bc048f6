#include "app/run/operator_command.h"

namespace skein::app {

std::optional<OperatorCommand> command_of(const Event& event) noexcept {
  using Command = std::optional<OperatorCommand>;
  using namespace events;
  return std::visit(
      Overloaded{
          [](const Start&) -> Command { return commands::Start{}; },
          [](const Stage&) -> Command { return commands::Stage{}; },
          [](const Pause&) -> Command { return commands::Pause{}; },
          [](const Resume&) -> Command { return commands::Resume{}; },
          [](const Gain& e) -> Command {
            return commands::SetGain{e.gain, e.to, e.ramp};
          },
          [](const PairGain& e) -> Command {
            return commands::SetPairGain{e.i, e.j, e.gain, e.to, e.ramp};
          },
          [](const Parameter& e) -> Command {
            return commands::SetParameter{e.name, e.from, e.to};
          },
          [](const Couple& e) -> Command {
            return commands::Couple{e.i, e.j, true};
          },
          [](const Uncouple& e) -> Command {
            return commands::Couple{e.i, e.j, false};
          },
          [](const Hold& e) -> Command {
            return commands::Hold{e.robot, true};
          },
          [](const Release& e) -> Command {
            return commands::Hold{e.robot, false};
          },
          [](const PutObstacle& e) -> Command {
            return commands::PutObstacle{e.number, e.obstacle};
          },
          [](const one_of<Stop, Perturb, Kidnap, Move, Kick, Schedule, ScheduleTracking, GainHeld, PairGainHeld, Lost,
                          Found, Avoid, Clear, Staged, Deadlock, NoWay, NoProgress, Outside, DeadlineMissed, VRise,
                          events::Link, CameraMoved, PicturesLate, CamerasDisagree, CamerasDiffer, CameraLost,
                          CameraFound, events::NotSeen, FilmBroken, Controller, NoNumber, Runaway, Obeys> auto&)
              -> Command { return std::nullopt; },
      },
      event);
}

}  // namespace skein::app
