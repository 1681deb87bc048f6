#include "ui/main/editor_controller.h"

#include "app/experiment/run_text.h"
#include "ui/editor/experiment_editor.h"

namespace skein::ui {

EditorController::EditorController(const Runs& runs, FileController& files, const Messages& messages, QObject* parent)
    : QObject(parent), runs_(runs), files_(files), messages_(messages) {
  connect(&files_, &FileController::broken, this, &EditorController::edit);
}

bool EditorController::ask_about_changes() const {
  bool asked = false;
  for (auto* editor : messages_.window()->findChildren<ExperimentEditor*>()) {
    if (!editor->has_changes()) continue;
    editor->raise();
    editor->reject();
    asked = true;
  }
  if (asked) messages_.say(tr("Not closed: an experiment has unsaved changes"), Severity::warning);
  return asked;
}

void EditorController::build_menu(QMenu* file) {
  const auto action = [&](const QString& text, const QString& name, const QKeySequence& keys, auto&& slot) {
    QAction* made = file->addAction(text, this, slot);
    made->setObjectName(name);
    made->setShortcut(keys);
  };
  action(tr("&Edit experiment …"), QStringLiteral("edit_experiment"), QKeySequence(tr("Ctrl+E")),
         [this] { edit_experiment(); });
  action(tr("Edit &with present gains …"), QStringLiteral("edit_present"), QKeySequence(tr("Ctrl+Shift+E")),
         [this] { edit_present(); });
  action(tr("Edit &as this run was done …"), QStringLiteral("edit_done"), QKeySequence(tr("Ctrl+Alt+E")),
         [this] { edit(as_done(), {}); });
}

void EditorController::edit(const QString& text, const QString& file) {
  open_editor(text, file);
}

void EditorController::edit_with(const std::vector<std::pair<QString, QString>>& values) {
  open_editor_with(values);
}

void EditorController::save_with(const std::vector<std::pair<QString, QString>>& values) {
  open_editor_with(values)->save_and_open();
}

void EditorController::edit_with_tables(const QString& tables) {
  open_editor_of_shown()->append(tables);
}

ExperimentEditor* EditorController::open_editor_with(const std::vector<std::pair<QString, QString>>& values) {
  ExperimentEditor* editor = open_editor_of_shown();
  for (const auto& [key, value] : values) editor->set_value(key, value);
  return editor;
}

ExperimentEditor* EditorController::open_editor_of_shown() {
  const RunSource& run = runs_.shown();
  const LiveRun& live = runs_.live();
  return open_editor(QString::fromStdString(run.experiment().source), run.file(),
                     run.file() == live.file() ? live.file_text() : QString());
}

ExperimentEditor* EditorController::open_editor(const QString& text, const QString& file, const QString& in_file) {
  auto* editor = new ExperimentEditor(messages_.window());
  connect(editor, &ExperimentEditor::open_wanted, &files_, &FileController::open);
  editor->edit(text, file, in_file);
  editor->show();
  return editor;
}

void EditorController::edit_experiment() {
  open_editor_of_shown();
}

/// The experiment with every pair's gains as they are now.
void EditorController::edit_present() {
  const RunSource& run = runs_.shown();
  const app::Experiment& experiment = run.experiment();
  if (!run.latest()) return messages_.say(tr("There are no gains to write: no run is open"), Severity::notice);
  core::CouplingGains gains = experiment.controller.gains;
  const std::size_t n = experiment.robots.size();
  for (const core::GainName name : core::gain_names)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) core::table(gains, name).set(i, j, run.gain_target(name, i, j));
  const auto text = app::text_with_gains(experiment.source, gains);
  if (!text) return messages_.problem(tr("The gains cannot be written"), QString::fromStdString(text.error()));
  edit(QString::fromStdString(*text), {});
}

/// The experiment with all that was done by hand, each at its time.
QString EditorController::as_done() const {
  const RunHistory::Rows kept = runs_.shown().rows();
  std::vector<const app::TickRecord*> rows;
  rows.reserve(kept.size());
  for (const auto& row : kept) rows.push_back(row.get());
  return QString::fromStdString(app::text_as_done(runs_.shown().experiment(), rows));
}

}  // namespace skein::ui
