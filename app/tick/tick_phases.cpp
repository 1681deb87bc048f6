// Where a run is: what the operator, the clock and the robots' places make of it.
#include <algorithm>
#include <cmath>

#include "app/experiment/at_start.h"
#include "app/tick/tick_state.h"

namespace skein::app {
namespace {

/// Staging is over when every robot has stood at its start for this long [s].
constexpr double staged_for = 0.5;

}  // namespace

/// Phase and time: the experiment's clock counts ticks, and stands still unless the experiment runs.
void TickState::begin(const TickInput& input) noexcept {
  record.events.clear();
  for (const Event& event : input.events) {
    note(event);
    if (const auto* const link = std::get_if<events::Link>(&event))
      link_lost[link->robot] = link->state != LinkState::up;
  }
  record.period = input.now - last_now;
  record.now = last_now = input.now;
  if (input.elapsed > 1) note(events::DeadlineMissed{input.elapsed - 1});

  dt = 0.0;
  motion_dt = moving() ? input.elapsed * experiment.period() : 0.0;
  if (running()) {
    record.tick += input.elapsed;
    dt = motion_dt;
  }
  if (record.phase == Phase::staging && stood_for >= staged_for) {
    record.phase = after_staging;
    note(events::Staged{});
  }
  for (const OperatorCommand& command : input.commands) obey(command, input.recorded);
  // A robot whose link is lost is held until the link is back and the operator releases it: somebody may be handling
  // the robot. A release that was given before the loss was known must not last beyond it.
  for (std::size_t i = 0; i < robots(); ++i)
    if (link_lost[i]) obey(commands::Hold{i, true}, input.recorded);
  if (input.stop && record.phase != Phase::stopped && record.phase != Phase::finished) {
    note(events::Stop{});
    record.phase = Phase::stopped;
  }
  if (running() && record.tick >= experiment.ticks()) record.phase = Phase::finished;
  record.t = static_cast<double>(record.tick) / experiment.rate;
}

void TickState::obey(const OperatorCommand& command, bool recorded) noexcept {
  const bool ready = record.phase == Phase::ready;
  std::visit(Overloaded{
                 [&](const commands::Start&) { start(); },
                 [&](const commands::Stage&) { stage(); },
                 [&](const commands::Pause&) { pause(); },
                 [&](const commands::Resume&) { resume(); },
                 [&](const commands::PutObstacle& put) {
                   if (obstacles.put(put.number, put.obstacle)) note(events::PutObstacle{put.number, put.obstacle});
                 },
                 [&](const commands::Hold& hold) {
                   if (hold.robot >= robots() || held[hold.robot] == hold.on) return;
                   held[hold.robot] = hold.on;
                   note(hold.on ? Event(events::Hold{hold.robot}) : Event(events::Release{hold.robot}));
                 },
                 [&](const commands::SetGain& set) { couplings.set(set, ready, recorded, record.events); },
                 [&](const commands::SetPairGain& set) { couplings.set(set, ready, recorded, record.events); },
                 [&](const commands::SetParameter& set) { law_parameters.set(set, record.events); },
                 [&](const commands::Couple& couple) { couplings.couple(couple, ready, recorded, record.events); },
             },
             command);
}

/// What was changed while nothing was recorded must be in the record, so that the run can be repeated from it.
void TickState::note_changes_before_start() noexcept {
  couplings.note_changes_before_start(record.events);
  law_parameters.note_changes_before_start(record.events);
  for (std::size_t k = 0; k < obstacles.all().size(); ++k) {
    const core::Obstacle first = k < experiment.obstacles.size() ? experiment.obstacles[k] : core::Obstacle{};
    const bool told = record.events.contains<events::PutObstacle>(k);
    if (obstacles.all()[k] != first && !told) note(events::PutObstacle{k, obstacles.all()[k]});
  }
  for (std::size_t i = 0; i < robots(); ++i)
    if (held[i] && !record.events.contains<events::Hold>(i)) note(events::Hold{i});
}

void TickState::start() noexcept {
  if (record.phase != Phase::ready) return;
  record.phase = Phase::running;
  forget_ways();
  couplings.finish_ramps();
  note_changes_before_start();
  note(events::Start{});
  forget_history();
}

void TickState::pause() noexcept {
  if (!moving()) return;
  if (running())
    record.phase = Phase::paused;
  else
    record.staging_paused = true;
  note(events::Pause{});
}

void TickState::resume() noexcept {
  if (!record.paused()) return;
  if (record.phase == Phase::paused) record.phase = Phase::running;
  record.staging_paused = false;
  note(events::Resume{});
  forget_history();
}

void TickState::stage() noexcept {
  if (record.phase != Phase::ready && record.phase != Phase::finished) return;
  after_staging = record.phase;
  record.phase = Phase::staging;
  record.staging_paused = false;
  stood_for = 0.0;
  forget_ways();
  if (after_staging == Phase::ready) note_changes_before_start();
  note(events::Stage{});
  forget_history();
}

/// Staging is over when every robot has stood at its start for a while. After a run, a robot that is held stays where
/// it is.
void TickState::watch_staging() noexcept {
  bool all_there = true;
  for (std::size_t i = 0; i < robots(); ++i) {
    if (held[i] && after_staging == Phase::finished) continue;
    const core::Pose& start = nominal[i].pose;
    all_there = all_there && !record.robots[i].is(lost) && on_nominal(i) && at_start(poses[i], start, staged_tolerance);
  }
  stood_for = all_there ? stood_for + motion_dt : 0.0;
}

}  // namespace skein::app
