// The experiment as a text: to be edited, or to be written down as it is now.
#include <QMenu>

#include "app/experiment/run_text.h"
#include "ui/editor/experiment_editor.h"
#include "ui/main/main_window.h"
#include "ui/run/alert_strip.h"

namespace skein::ui {

void MainWindow::build_editor_menu(QMenu* file) {
  const auto action = [&](const QString& text, const QString& name, const QKeySequence& keys, auto&& slot) {
    QAction* made = file->addAction(text, this, slot);
    made->setObjectName(name);
    made->setShortcut(keys);
  };
  action(tr("&Edit experiment …"), QStringLiteral("edit_experiment"), QKeySequence(tr("Ctrl+E")), [this] {
    edit(QString::fromStdString(shown_experiment().source), player_.is_loaded() ? QString() : experiment_file_);
  });
  action(tr("Edit &with present gains …"), QStringLiteral("edit_present"), QKeySequence(tr("Ctrl+Shift+E")),
         [this] { edit_present(); });
  action(tr("Edit &as this run was done …"), QStringLiteral("edit_done"), QKeySequence(tr("Ctrl+Alt+E")),
         [this] { edit(experiment_as_done(), {}); });
}

void MainWindow::edit(const QString& text, const QString& file) {
  auto* editor = new ExperimentEditor(this);
  connect(editor, &ExperimentEditor::open_wanted, this, &MainWindow::open_file);
  editor->edit(text, file);
  editor->show();
}

/// The experiment with every pair's gains as they are now.
void MainWindow::edit_present() {
  const app::Experiment& experiment = shown_experiment();
  if (player_.is_loaded() ? player_.latest().pair_gains.empty() : !live_.is_open())
    return alert_->say(tr("There are no gains to write down: no run is open"), Severity::notice);
  core::CouplingGains gains = experiment.controller.gains;
  const std::size_t n = experiment.robots.size();
  for (const core::GainName name : core::gain_names)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        core::table(gains, name)
            .set(i, j, player_.is_loaded() ? player_.latest().pair_gain(name, i, j) : live_.gain_target(name, i, j));
  const auto text = app::text_with_gains(experiment.source, gains);
  if (!text) return show_problem(tr("The gains cannot be written down"), QString::fromStdString(text.error()));
  edit(QString::fromStdString(*text), {});
}

/// The experiment with all that was done by hand, each at its time.
QString MainWindow::experiment_as_done() const {
  std::vector<const app::TickRecord*> rows;
  const RunHistory::Rows kept = live_.history().rows();
  if (player_.is_loaded())
    for (const app::TickRecord& row : player_.run()->rows) rows.push_back(&row);
  else
    for (const auto& row : kept) rows.push_back(row.get());
  return QString::fromStdString(app::text_as_done(shown_experiment(), rows));
}

}  // namespace skein::ui
