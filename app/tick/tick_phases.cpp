// Where a run is: what the operator, the clock and the robots' places make of it.
#include <algorithm>
#include <cmath>

#include "app/tick/tick_state.h"

namespace skein::app {
namespace {

/// Staging is over when everybody has stood so long [s] so near to its start [m, rad].
constexpr double staged_for = 0.5;
constexpr double staged_distance = 0.012;
constexpr double staged_angle = 0.05;

}  // namespace

/// Phase and time: the experiment's clock counts ticks, and stands still unless the experiment runs.
void TickState::begin(const TickInput& input) noexcept {
  record.events = input.events;
  record.period = input.now - last_now;
  record.now = last_now = input.now;
  if (input.elapsed > 1)
    record.events.add({Event::Kind::deadline_missed, -1, {}, {static_cast<double>(input.elapsed - 1), 0.0, 0.0}});

  dt = 0.0;
  motion_dt = moving() ? input.elapsed * experiment.period() : 0.0;
  if (running()) {
    record.tick += input.elapsed;
    dt = motion_dt;
  }
  if (record.phase == Phase::staging && stood_for >= staged_for) {
    record.phase = after_staging;
    record.events.add({Event::Kind::staged, -1, {}, {}});
  }
  for (const OperatorCommand& command : input.commands) obey(command);
  if (input.stop && record.phase != Phase::stopped && record.phase != Phase::finished) {
    record.events.add({Event::Kind::stop, -1, {}, {}});
    record.phase = Phase::stopped;
  }
  if (running() && record.tick >= experiment.ticks()) record.phase = Phase::finished;
  record.t = static_cast<double>(record.tick) / experiment.rate;
}

void TickState::obey(const OperatorCommand& command) noexcept {
  switch (command.kind) {
    case OperatorCommand::Kind::start:
      if (record.phase != Phase::ready) return;
      record.phase = Phase::running;
      for (std::size_t i = 0; i < robots(); ++i) avoidance.reset(i);
      couplings.note_changes_before_start(record.events);
      for (std::size_t k = 0; k < obstacles.all().size(); ++k) {
        const core::Obstacle first = k < experiment.obstacles.size() ? experiment.obstacles[k] : core::Obstacle{};
        const bool told = record.events.contains(Event::Kind::obstacle, static_cast<int>(k));
        if (obstacles.all()[k] != first && !told) note_obstacle(k, obstacles.all()[k]);
      }
      for (std::size_t i = 0; i < robots(); ++i)
        if (held[i] && !record.events.contains(Event::Kind::hold, static_cast<int>(i))) note(Event::Kind::hold, i);
      record.events.add({Event::Kind::start, -1, {}, {}});
      forget_history();
      return;
    case OperatorCommand::Kind::pause:
      if (record.phase != Phase::running) return;
      record.phase = Phase::paused;
      record.events.add({Event::Kind::pause, -1, {}, {}});
      return;
    case OperatorCommand::Kind::resume:
      if (record.phase != Phase::paused) return;
      record.phase = Phase::running;
      record.events.add({Event::Kind::resume, -1, {}, {}});
      forget_history();
      return;
    case OperatorCommand::Kind::obstacle:
      if (obstacles.put(command.number, command.obstacle)) note_obstacle(command.number, command.obstacle);
      return;
    case OperatorCommand::Kind::hold:
    case OperatorCommand::Kind::release: {
      const bool hold = command.kind == OperatorCommand::Kind::hold;
      if (command.number >= robots() || held[command.number] == hold) return;
      held[command.number] = hold;
      note(hold ? Event::Kind::hold : Event::Kind::release, command.number);
      return;
    }
    case OperatorCommand::Kind::stage:
      if (record.phase != Phase::ready && record.phase != Phase::finished) return;
      after_staging = record.phase;
      record.phase = Phase::staging;
      stood_for = 0.0;
      for (std::size_t i = 0; i < robots(); ++i) avoidance.reset(i);
      record.events.add({Event::Kind::stage, -1, {}, {}});
      forget_history();
      return;
    case OperatorCommand::Kind::gain:
    case OperatorCommand::Kind::pair_gain:
    case OperatorCommand::Kind::couple:
    case OperatorCommand::Kind::uncouple:
      couplings.obey(command, record.phase == Phase::ready, record.events);
      return;
  }
}

/// Staging is over when everybody has stood at its start for a while.
void TickState::watch_staging() noexcept {
  bool all_there = true;
  for (std::size_t i = 0; i < robots(); ++i) {
    const core::Pose& start = nominal[i].pose;
    all_there = all_there && !record.robots[i].is(lost) && avoidance.state(i) == core::Avoidance::State::nominal &&
                core::distance(poses[i], start) < staged_distance &&
                std::abs(core::wrap_angle(poses[i].theta - start.theta)) < staged_angle;
  }
  stood_for = all_there ? stood_for + motion_dt : 0.0;
}

}  // namespace skein::app
