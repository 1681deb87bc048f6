#include "ui/main/comparison_controller.h"

#include <QFileInfo>
#include <algorithm>
#include <cmath>

#include "ui/arena/arena_view.h"
#include "ui/base/dialogs.h"
#include "ui/main/recording_controller.h"
#include "ui/plots/plots_panel.h"

namespace skein::ui {

ComparisonController::ComparisonController(const Runs& runs, const Messages& messages, ArenaView* arena,
                                           PlotsPanel* plots, QObject* parent)
    : QObject(parent), runs_(runs), messages_(messages), arena_(arena), plots_(plots) {
  connect(&runs, &Runs::changed, this, [this] { arena_->set_other(other_at(runs_.shown().t())); });
}

void ComparisonController::build_menu(QMenu* file) {
  const auto action = [&](const QString& text, const QString& name, const QKeySequence& keys, auto&& slot) {
    QAction* made = file->addAction(text, this, slot);
    made->setObjectName(name);
    made->setShortcut(keys);
  };
  action(tr("&Compare with …"), QStringLiteral("compare"), QKeySequence(tr("Ctrl+D")), [this] { ask(); });
  action(tr("Compare with this run as it is &now"), QStringLiteral("compare_now"), {}, [this] { compare_with_now(); });
  action(tr("&End the comparison"), QStringLiteral("compare_end"), {}, [this] { compare(nullptr); });
}

void ComparisonController::ask() {
  QFileDialog* dialog = file_dialog(messages_.window(), {tr("Compare with"),
                                                         QStringLiteral("compare_dialog"),
                                                         tr("Recorded runs (*.csv);;All files (*)"),
                                                         RecordingController::directory(),
                                                         {}});
  connect(dialog, &QFileDialog::fileSelected, this, &ComparisonController::load);
  dialog->show();
}

void ComparisonController::load(const QString& file) {
  if (loader_.is_busy()) return;
  messages_.say(tr("Reading %1 …").arg(QFileInfo(file).fileName()), Severity::note);
  loader_.load(file.toStdString());
}

void ComparisonController::refresh() {
  if (auto run = loader_.take()) {
    if (!*run) return messages_.problem(tr("This recording cannot be read"), QString::fromStdString(run->error()));
    compare(std::make_shared<const app::RecordedRun>(std::move(**run)));
  }
  if (other_ && runs_.shown().latest()) arena_->set_other(other_at(runs_.shown().t()));
}

void ComparisonController::show_experiment() {
  const bool comparable = other_ && other_->experiment.robots.size() == runs_.shown().experiment().robots.size();
  if (!comparable) other_ = nullptr;
  if (other_) plots_->compare(&other_->rows);
  emit compared(other_);
  arena_->set_other(std::nullopt);
}

void ComparisonController::compare(ReplayRun::Recording other) {
  const std::size_t robots = runs_.shown().experiment().robots.size();
  if (other && other->experiment.robots.size() != robots) {
    messages_.problem(tr("These runs cannot be compared"),
                      tr("%1 has %2 robots, this experiment %3.")
                          .arg(QFileInfo(QString::fromStdString(other->file)).fileName())
                          .arg(other->experiment.robots.size())
                          .arg(robots));
    return;
  }
  other_ = std::move(other);
  plots_->compare(other_ ? &other_->rows : nullptr);
  emit compared(other_);
  arena_->set_other(other_at(runs_.shown().t()));
  if (other_)
    messages_.say(tr("Pale: %1").arg(QFileInfo(QString::fromStdString(other_->file)).fileName()), Severity::note);
}

void ComparisonController::compare_with_now() {
  auto run = std::make_shared<app::RecordedRun>();
  run->file = tr("the run before").toStdString();
  run->experiment = runs_.shown().experiment();
  for (const auto& row : runs_.shown().rows()) run->rows.push_back(*row);
  if (run->rows.empty()) return messages_.say(tr("There is no run yet to compare with"), Severity::notice);
  compare(std::move(run));
}

/// The other run's robots where they were at this time, and where they had come from.
std::optional<OtherRun> ComparisonController::other_at(double t) const {
  if (!other_) return std::nullopt;
  const auto& rows = other_->rows;
  const auto row_at = [&](double when) {
    return std::partition_point(rows.begin(), rows.end(), [&](const app::TickRecord& row) { return row.t <= when; });
  };
  const auto from = row_at(t - ArenaScene::trail_seconds), to = row_at(t);
  OtherRun other;
  other.name = QFileInfo(QString::fromStdString(other_->file)).fileName();
  other.trails.resize(rows.front().robots.size());
  for (auto row = from; row != to; ++row)
    for (std::size_t i = 0; i < other.trails.size() && row->phase != app::Phase::staging; ++i) {
      const app::RobotRecord& robot = row->robots[i];
      const core::Pose& pose = std::isfinite(robot.truth.x) ? robot.truth : robot.pose;
      if (std::isfinite(pose.x)) other.trails[i].push_back(pose);
    }
  return other;
}

}  // namespace skein::ui
