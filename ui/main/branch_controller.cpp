#include "ui/main/branch_controller.h"

#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/experiment/run_text.h"

namespace skein::ui {
namespace {

constexpr double fastest = 50.0;  // times real time

}  // namespace

BranchController::BranchController(Runs& runs, const Messages& messages, QObject* parent)
    : QObject(parent), runs_(runs), messages_(messages) {
  connect(&runs_.live(), &LiveRun::record_shown, this, &BranchController::show_record);
}

void BranchController::build_menu(QMenu* run) {
  QAction* action = run->addAction(tr("&Go on from here"), this, &BranchController::go_on_from_here);
  action->setObjectName(QStringLiteral("go_on_from_here"));
  action->setShortcut(QKeySequence(tr("Ctrl+B")));
  action->setToolTip(
      tr("Repeats a simulation, or the replay of one, up to this moment and pauses: from there on it is yours"));
}

void BranchController::go_on_from_here() {
  const RunSource& shown = runs_.shown();
  const app::Experiment& experiment = shown.experiment();
  if (const auto why = app::real_time_reason(experiment))
    return messages_.say(tr("Only a simulation can be repeated: %1").arg(QString::fromStdString(*why)),
                         Severity::notice);
  const RunHistory::Rows kept = shown.rows();
  const double t = shown.t();
  std::vector<const app::TickRecord*> rows;
  for (const auto& row : kept)
    if (row->t <= t) rows.push_back(row.get());
  if (rows.empty() || runs_.live().is_busy())
    return messages_.say(tr("There is no run yet to go on from"), Severity::notice);
  // What was done after this moment is what may now be done otherwise.
  const auto later = [t](const app::OperatorAction& action) { return action.t > t; };
  app::Experiment until_here = experiment;
  std::erase_if(until_here.actions, later);
  auto repeated = app::parse_experiment(app::text_as_done(until_here, rows), experiment.name);
  if (!repeated)
    return messages_.problem(tr("This run cannot be repeated"),
                             QString::fromStdString(repeated.error().front().message()));
  repeated->directory = experiment.directory;
  std::erase_if(repeated->actions, later);
  repeated->actions.push_back({t, app::events::Pause{}});
  if (!pause_at_) speed_ = runs_.live().is_open() ? runs_.live().speed() : 1.0;
  pause_at_ = began_at_ = t;
  emit experiment_wanted(*repeated);
  (void)runs_.live().set_speed(fastest);  // no session is open yet: it is kept for the one that comes
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
