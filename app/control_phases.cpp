// Where a run is: what the operator, the clock and the robots' places make of it.
#include <algorithm>
#include <cmath>
#include <limits>

#include "app/control_tick_state.h"

namespace skein::app {
namespace {

/// An operator's change of a gain takes at least five seconds from nothing to all of the authority there is: Theorem 1
/// wants gains that are continuous, and a hand on a slider is not.
constexpr double operator_ramp = 5.0;

/// Staging is over when everybody has stood so long [s] so near to its start [m, rad].
constexpr double staged_for = 0.5;
constexpr double staged_distance = 0.012;
constexpr double staged_angle = 0.05;

}  // namespace

/// Phase and time: the experiment's clock counts ticks, and stands still unless the experiment runs.
void ControlTick::State::begin(const TickInput& input) noexcept {
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

void ControlTick::State::obey(const OperatorCommand& command) noexcept {
  switch (command.kind) {
    case OperatorCommand::Kind::start:
      if (record.phase != Phase::ready) return;
      record.phase = Phase::running;
      for (std::size_t i = 0; i < robots(); ++i) avoidance.reset(i);
      // What was changed before the run began belongs into its record, or it could not be repeated from it.
      for (const core::GainName name : core::gain_names)
        if (changed_before_start[static_cast<std::size_t>(name)])
          note_gain(Event::Kind::gain, name, core::table(experiment.controller.gains, name).largest(),
                    core::table(schedule.target(), name).largest());
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
    case OperatorCommand::Kind::gain: {
      const double border = core::gain_border(command.gain, gains, schedule.target(), demand);
      const double value = std::clamp(command.value, 0.0, border);
      const double from = core::table(schedule.target(), command.gain).largest();
      if (command.value > border) note_gain(Event::Kind::gain_held, command.gain, command.value, value);
      if (value == from) return;
      if (record.phase == Phase::ready) {  // no motion yet that a jump could disturb
        schedule.move(command.gain, value, std::numeric_limits<double>::infinity());
        schedule.step(1.0);
        changed_before_start[static_cast<std::size_t>(command.gain)] = true;
        note_gain(Event::Kind::gain, command.gain, from, value);
        return;
      }
      const double authority = command.gain == core::GainName::k_xx ? gains.v_max[0] : gains.omega_max[0];
      const auto partners = static_cast<double>(std::max<std::size_t>(1, robots() - 1));
      schedule.move(command.gain, value, authority / partners / operator_ramp);
      note_gain(Event::Kind::gain, command.gain, from, value);
      return;
    }
  }
}

/// Staging is over when everybody has stood at its start for a while.
void ControlTick::State::watch_staging() noexcept {
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
