// The experiment as a text: to be edited, or to be written down as it is now.
#include <fmt/format.h>

#include <QMenu>
#include <tuple>

#include "app/toml_edit.h"
#include "ui/alert_strip.h"
#include "ui/experiment_editor.h"
#include "ui/main_window.h"

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
  action(tr("Edit &with present gains and moves …"), QStringLiteral("edit_present"), QKeySequence(tr("Ctrl+Shift+E")),
         [this] { edit(present_experiment(), {}); });
}

void MainWindow::edit(const QString& text, const QString& file) {
  auto* editor = new ExperimentEditor(this);
  connect(editor, &ExperimentEditor::open_wanted, this, &MainWindow::open_file);
  editor->edit(text, file);
  editor->show();
}

/// The experiment with the gains as they are now, and what the operator did to the robots as perturbations.
QString MainWindow::present_experiment() const {
  const app::Experiment& experiment = shown_experiment();
  std::string text = experiment.source;
  const app::TickRecord* now = player_.is_loaded() ? &player_.latest() : live_.latest();
  if (!now) return QString::fromStdString(text);
  for (const auto& [key, value, before] : {std::tuple{"k_xx", now->k_xx, experiment.controller.gains.k_xx.largest()},
                                           {"k_tt", now->k_tt, experiment.controller.gains.k_tt.largest()},
                                           {"k_yy", now->k_yy, experiment.controller.gains.k_yy.largest()}})
    if (value != before)
      if (auto changed = app::with_toml_value(text, fmt::format("controller.gains.{}", key), fmt::format("{}", value)))
        text = *changed;
  if (!text.empty() && text.back() != '\n') text += '\n';
  const RunHistory::Rows rows = live_.history().rows();
  const app::TickRecord* last = nullptr;
  const auto moves = [&](const app::TickRecord& row) {
    for (const app::Event& event : row.events) {
      const auto i = static_cast<std::size_t>(std::max(0, event.robot));
      if (event.kind != app::Event::Kind::move || !last || i >= last->robots.size()) continue;
      const core::Pose& from = last->robots[i].truth;
      text += fmt::format("\n[[perturb]]\nt = {}\nrobot = {}\ndx = {:.4f}\ndy = {:.4f}\ndtheta = {:.4f}\n", row.t,
                          i + 1, event.values[0] - from.x, event.values[1] - from.y,
                          core::wrap_angle(event.values[2] - from.theta));
    }
    last = &row;
  };
  if (player_.is_loaded())
    for (const app::TickRecord& row : player_.run()->rows) moves(row);
  else
    for (const auto& row : rows) moves(*row);
  return QString::fromStdString(text);
}

}  // namespace skein::ui
