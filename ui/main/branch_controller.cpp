#include "ui/main/branch_controller.h"

#include <algorithm>
#include <utility>

#include "app/experiment/experiment_file.h"
#include "app/experiment/run_text.h"

namespace skein::ui {
namespace {

constexpr double one_gesture = 0.5;  // actions that follow one another within this time [s]

bool acts(const app::TickRecord& row) {
  return std::any_of(row.events.begin(), row.events.end(), app::is_action);
}

}  // namespace

BranchController::BranchController(Runs& runs, const Messages& messages, QObject* parent)
    : QObject(parent), runs_(runs), messages_(messages) {
  connect(&runs_.live(), &LiveRun::record_shown, this, &BranchController::show_record);
  connect(&runs_, &Runs::shown_changed, this, &BranchController::drop);
}

void BranchController::build_menu(QMenu* run) {
  QAction* action = run->addAction(tr("&Go on from here"), this, &BranchController::go_on_from_here);
  action->setObjectName(QStringLiteral("go_on_from_here"));
  action->setShortcut(QKeySequence(tr("Ctrl+B")));
  action->setToolTip(
      tr("Repeats a simulation, or the replay of one, up to this moment and pauses: from there on it is yours"));
  action = run->addAction(tr("Take the last action &back"), this, &BranchController::take_back);
  action->setObjectName(QStringLiteral("take_back"));
  action->setShortcut(QKeySequence(tr("Ctrl+Alt+Z")));
  action->setToolTip(
      tr("Repeats a simulation up to the moment before the last drag, kick, obstacle, gain, coupling or hold"));
  action = run->addAction(tr("Do th&e action again"), this, &BranchController::do_again);
  action->setObjectName(QStringLiteral("do_again"));
  action->setShortcut(QKeySequence(tr("Ctrl+Alt+Shift+Z")));
  action->setToolTip(tr("Repeats the simulation with the action that was taken back last"));
}

/// How many rows of the shown run are not later than the moment that is shown.
std::size_t BranchController::rows_so_far() const {
  const RunHistory::Rows rows = runs_.shown().rows();
  const auto later = [t = runs_.shown().t()](const auto& row) { return row->t > t; };
  return static_cast<std::size_t>(std::find_if(rows.begin(), rows.end(), later) - rows.begin());
}

/// A run's first so many rows, with everything that was done in them. The error: why it cannot be repeated.
BranchController::Prepared BranchController::past(app::Experiment until_here, const RunHistory::Rows& kept,
                                                  std::size_t count) {
  std::vector<const app::TickRecord*> rows;
  rows.reserve(count);
  for (std::size_t k = 0; k < count; ++k) rows.push_back(kept[k].get());
  const double t = rows.back()->t;
  // What was done after this moment is what may now be done otherwise.
  const auto undone = [&](const app::OperatorAction& action) {
    const auto did = [&](const auto& row) {
      return row->t == action.t && std::any_of(row->events.begin(), row->events.end(), [&](const app::Event& event) {
               return app::describe(event) == app::describe(action.event);
             });
    };
    return action.t > t || std::any_of(kept.begin() + static_cast<std::ptrdiff_t>(count), kept.end(), did);
  };
  std::erase_if(until_here.actions, undone);
  auto repeated = app::parse_experiment(app::text_as_done(until_here, rows), until_here.name);
  if (!repeated) return tl::unexpected(repeated.error().front().message());
  repeated->directory = until_here.directory;
  std::erase_if(repeated->actions, undone);  // those of a table in one line are still in the text
  repeated->actions.push_back({t, app::events::Pause{}});
  return Past{*std::move(repeated), t};
}

bool BranchController::can_be_repeated(std::size_t count) const {
  if (const auto why = app::real_time_reason(runs_.shown().experiment())) {
    messages_.say(tr("Only a simulation can be repeated: %1").arg(QString::fromStdString(*why)), Severity::notice);
    return false;
  }
  if (count > 0 && !runs_.live().is_busy()) return true;
  messages_.say(tr("There is no run yet to go on from"), Severity::notice);
  return false;
}

void BranchController::prepare(std::size_t to, std::optional<std::size_t> from) {
  RunHistory::Rows rows = runs_.shown().rows();
  preparing_to_ = rows[to - 1]->t;
  preparing_.run([experiment = runs_.shown().experiment(), rows = std::move(rows), to, from](const std::stop_token&) {
    Wanted wanted{past(experiment, rows, to), {}};
    if (from) wanted.from = past(experiment, rows, *from);
    return wanted;
  });
  messages_.say(doing(), Severity::note);
}

QString BranchController::doing() const {
  return is_busy() ? tr("Preparing the run up to %1 s …").arg(preparing_to_, 0, 'f', 2) : QString();
}

void BranchController::drop() {
  if (!is_busy()) return;
  preparing_.drop();
  messages_.say(tr("The run is not repeated"), Severity::notice);
}

void BranchController::refresh() {
  if (runs_.live().is_busy()) return;
  auto wanted = preparing_.take();
  if (!wanted) return;
  for (const Prepared* one : {&wanted->to, wanted->from ? &*wanted->from : nullptr})
    if (one && !*one) return messages_.problem(tr("This run cannot be repeated"), QString::fromStdString(one->error()));
  if (wanted->from) {
    if (runs_.shown().experiment().source != branch_) taken_back_.clear();
    taken_back_.push_back(**std::move(wanted->from));
    branch_ = wanted->to->experiment.source;
  }
  repeat(*wanted->to);
}

void BranchController::repeat(const Past& past) {
  if (!pause_at_) speed_ = runs_.live().is_open() ? runs_.live().speed() : 1.0;
  pause_at_ = began_at_ = past.t;
  emit experiment_wanted(past.experiment);
  (void)runs_.live().set_speed(app::Session::fastest);  // no session is open yet: it is kept for the one that comes
}

void BranchController::go_on_from_here() {
  if (is_busy()) return;
  if (const std::size_t now = rows_so_far(); can_be_repeated(now)) prepare(now, {});
}

void BranchController::take_back() {
  if (is_busy()) return;
  const RunHistory::Rows rows = runs_.shown().rows();
  const std::size_t now = rows_so_far();
  std::size_t before = 0;       // so many rows are before the first of the last actions
  std::optional<double> acted;  // when that was, by the session's clock: time stands while a run pauses [s]
  for (std::size_t k = now; k-- > 0 && !(acted && rows[k]->now < *acted - one_gesture);)
    if (acts(*rows[k])) acted = rows[before = k]->now;
  if (before == 0 || rows[before - 1]->phase == app::Phase::staging)
    return messages_.say(tr("Nothing has been done to this run that could be taken back"), Severity::notice);
  if (can_be_repeated(before)) prepare(before, now);
}

void BranchController::do_again() {
  if (is_busy()) return;
  const RunHistory::Rows rows = runs_.shown().rows();
  const auto paused = std::find_if(rows.begin(), rows.end(), [this](const auto& row) {
    return began_at_ && row->t >= *began_at_ && row->events.template contains<app::events::Pause>();
  });
  const bool otherwise =
      paused != rows.end() && std::any_of(std::next(paused), rows.end(), [](const auto& row) { return acts(*row); });
  if (otherwise || runs_.shown().experiment().source != branch_) taken_back_.clear();
  if (taken_back_.empty())
    return messages_.say(tr("Nothing has been taken back since the last action"), Severity::notice);
  const Past again = std::move(taken_back_.back());
  taken_back_.pop_back();
  branch_ = again.experiment.source;
  repeat(again);
}

void BranchController::forget_pause(app::Experiment& experiment) const {
  std::erase_if(experiment.actions, [this](const app::OperatorAction& action) {
    return action.t == began_at_ && app::is<app::events::Pause>(action.event);
  });
}

void BranchController::show_record(const app::TickRecord& record) {
  if (!pause_at_ || !record.events.contains<app::events::Pause>()) return;
  messages_.tell(runs_.live().set_speed(speed_));
  messages_.note(tr("Repeated up to %1 s. Change what you like; F5 goes on").arg(*pause_at_, 0, 'f', 2),
                 Severity::note);
  pause_at_.reset();
}

}  // namespace skein::ui
