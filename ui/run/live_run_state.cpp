// What a live run says of itself: its state for bar and menus, its banner, who has acknowledged a stop.
#include <algorithm>

#include "ui/run/live_run.h"

namespace skein::ui {
namespace {

/// Robots from 0, as "2, 3".
QString numbers(const std::vector<std::size_t>& robots) {
  QStringList from_one;
  for (const std::size_t robot : robots) from_one << QString::number(robot + 1);
  return from_one.join(QStringLiteral(", "));
}

Severity phase_tone(app::Phase phase) {
  switch (phase) {
    case app::Phase::stopped:
      return Severity::alarm;
    case app::Phase::running:
      return Severity::good;
    case app::Phase::paused:
      return Severity::warning;
    case app::Phase::ready:
    case app::Phase::staging:
    case app::Phase::finished:
      return Severity::notice;
  }
  return Severity::notice;
}

/// What the button does in this phase.
RunState::Go go_from(app::Phase phase, bool paused) {
  switch (phase) {
    case app::Phase::running:
    case app::Phase::staging:
    case app::Phase::paused:
      return paused ? RunState::Go::resume : RunState::Go::pause;
    case app::Phase::stopped:
    case app::Phase::finished:
      return RunState::Go::again;
    case app::Phase::ready:
      return RunState::Go::start;
  }
  return RunState::Go::start;
}

}  // namespace

bool LiveRun::is_before_start() const {
  const bool failed = has_failed() && failure_;
  return failed || (session_ && phase() == app::Phase::ready);
}

bool LiveRun::is_under_way() const {
  return phase() == app::Phase::running || phase() == app::Phase::paused || phase() == app::Phase::staging;
}

bool LiveRun::all_stand() const {
  return session_ && latest_ && phase() == app::Phase::ready && !start_at_once_ && !tests_ && !stop_asked_;
}

RunState LiveRun::state() const {
  using app::Phase;
  const bool busy = is_opening(), failed = has_failed(), there = !busy && !failed;
  const bool empty = failed && !failure_;  // no experiment was opened yet
  const QString real_time = real_time_reason();
  RunState state;
  state.words = busy                                       ? tr("Opening …")
                : empty                                    ? tr("No experiment")
                : failed                                   ? tr("Failed")
                : phase() == Phase::staging && is_paused() ? tr("Staging, paused")
                                                           : phase_text(phase());
  state.tone = busy          ? Severity::note
               : empty       ? Severity::notice
               : failed      ? Severity::alarm
               : is_paused() ? phase_tone(Phase::paused)
                             : phase_tone(phase());
  state.moves = there && phase() == Phase::running;
  state.t = t();
  if (!empty && !is_over()) state.end = experiment_.duration;
  state.has_time = !empty;
  state.speed = speed();
  state.go = go_from(phase(), is_paused());
  state.may_go = there;
  const bool stands = phase() == Phase::ready || phase() == Phase::paused;
  state.step.possible = there && stands && real_time.isEmpty();
  state.step.tip = !real_time.isEmpty() ? tr("Simulations only: %1").arg(real_time)
                   : stands             ? tr("One tick on, and pause (F6)")
                                        : tr("One tick on (F6): pause first");
  state.change_speed.possible = real_time.isEmpty();
  state.change_speed.tip = real_time.isEmpty() ? tr("How much faster than real time it goes (Ctrl+Up, Ctrl+Down)")
                                               : tr("Simulations only: %1").arg(real_time);
  state.new_run_text = tr("New run");
  state.new_run = {!is_busy(), tr("Ends this run and sets the same experiment up again (Ctrl+N)")};
  state.records = records_next_ || !record_file_.isEmpty();
  state.record.possible = records_next_ || !is_over();
  state.record.tip = !record_file_.isEmpty() ? tr("Recording to %1").arg(record_file_)
                     : records_next_
                         ? tr("Every run from now on is recorded, as CSV and the camera's film (Ctrl+R)")
                         : tr("Records this run from its beginning, and those that follow, as CSV (Ctrl+R)");
  state.may_save = history_.size() > 0;
  return state;
}

Notice LiveRun::banner() const {
  if (is_opening()) return {tr("Opening …")};
  if (has_failed())
    return failure_ ? Notice{tr("The experiment could not be opened"), Severity::alarm}
                    : Notice{tr("No experiment is open – open one with Ctrl+O")};
  if (const auto robots = may_be_driving(); !robots.empty() && stop_is_due()) {
    const QString said = robots.size() == 1 ? tr("Robot %1 MAY BE DRIVING: it has not acknowledged its stop")
                                            : tr("Robots %1 MAY BE DRIVING: they have not acknowledged their stop");
    return {said.arg(numbers(robots)), Severity::alarm};
  }
  switch (phase()) {
    case app::Phase::ready:
      return {tr("Ready – start with F5")};
    case app::Phase::paused:
      return {tr("Paused – reference and robots stand")};
    case app::Phase::stopped:
      return {stopped_text(), Severity::alarm};
    case app::Phase::finished:
      return {tr("Finished – new run: Ctrl+N")};
    case app::Phase::staging:
      return is_paused() ? Notice{tr("Paused – the robots stand on the way to their starts")} : Notice{};
    case app::Phase::running:
      return {};
  }
  return {};
}

QString LiveRun::why_fixed() const {
  return is_over() ? tr("The run is over: nothing in it can be changed. New run (Ctrl+N) sets it up again") : QString();
}

Notice LiveRun::lasting_alert() const {
  if (!session_ || phase() != app::Phase::stopped) return {};
  return {stopped_text() + acknowledgements(), Severity::alarm};
}

std::vector<std::size_t> LiveRun::may_be_driving() const {
  std::vector<std::size_t> robots;
  if (!latest_) return robots;
  const bool all_stop = phase() == app::Phase::stopped || is_finished_for(1000);
  const auto& specs = experiment_.robots;
  for (std::size_t i = 0; i < specs.size() && i < robots_.size() && i < latest_->robots.size(); ++i) {
    if (!specs[i].has_link() || robots_[i].stop_acknowledged) continue;
    // During a run, a robot whose link is lost is told to stand, and does not answer.
    const bool alone = is_under_way() && latest_->robots[i].is(app::stopped) && robots_[i].link != app::LinkState::up;
    if (all_stop || alone) robots.push_back(i);
  }
  return robots;
}

QString LiveRun::stopped_text() const {
  return failure_ ? tr("STOPPED: %1").arg(*failure_) : tr("STOPPED by operator – new run: Ctrl+N");
}

QString LiveRun::acknowledgements() const {
  const auto& specs = experiment_.robots;
  const bool any_link = std::any_of(specs.begin(), specs.end(), [](const auto& robot) { return robot.has_link(); });
  if (!any_link) return {};
  const auto robots = may_be_driving();
  if (robots.empty()) return tr(". All robots have acknowledged.");
  const bool one = robots.size() == 1;
  const QString waits =
      one ? tr(". Waiting for robot %1 to acknowledge.") : tr(". Waiting for robots %1 to acknowledge.");
  const QString overdue = one ? tr(". NOT acknowledged by robot %1: it may be driving!")
                              : tr(". NOT acknowledged by robots %1: they may be driving!");
  return (stop_is_due() ? overdue : waits).arg(numbers(robots));
}

}  // namespace skein::ui
