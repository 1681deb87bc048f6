#include "ui/main/comparison_controller.h"

#include <algorithm>
#include <cmath>

#include "ui/arena/arena_view.h"
#include "ui/base/compared.h"
#include "ui/base/dialogs.h"
#include "ui/main/recording_controller.h"
#include "ui/plots/comparison_bar.h"
#include "ui/plots/plots_panel.h"
#include "ui/run/run_name.h"

namespace skein::ui {
namespace {

constexpr qint64 kicks_ms = 1000;

}  // namespace

ComparisonController::ComparisonController(const Runs& runs, const Messages& messages, ArenaView* arena,
                                           PlotsPanel* plots, QObject* parent)
    : QObject(parent), runs_(runs), messages_(messages), arena_(arena), plots_(plots) {
  connect(&runs, &Runs::changed, this, [this] { arena_->set_others(others_at(runs_.shown().t())); });
  connect(&plots_->comparison_bar(), &ComparisonBar::switched, this, [this](int run, bool on) {
    others_[static_cast<std::size_t>(run)].shown = on;
    show();
  });
  connect(&plots_->comparison_bar(), &ComparisonBar::align_wanted, this, &ComparisonController::align);
}

void ComparisonController::build_menu(QMenu* file) {
  const auto action = [&](const QString& text, const QString& name, const QKeySequence& keys, auto&& slot) {
    QAction* made = file->addAction(text, this, slot);
    made->setObjectName(name);
    made->setShortcut(keys);
  };
  action(tr("Co&mpare with …"), QStringLiteral("compare"), QKeySequence(tr("Ctrl+D")), [this] { ask(); });
  action(tr("Compare with this run as it is &now"), QStringLiteral("compare_now"), {}, [this] { compare_with_now(); });
  action(tr("En&d the comparison"), QStringLiteral("compare_end"), {}, [this] { end(); });
}

void ComparisonController::ask() {
  QFileDialog* dialog = file_dialog(messages_.window(), {tr("Compare with"),
                                                         QStringLiteral("compare_dialog"),
                                                         tr("Recorded runs (*.csv);;All files (*)"),
                                                         RecordingController::directory(),
                                                         {},
                                                         RecordingController::places()});
  dialog->setFileMode(QFileDialog::ExistingFiles);
  connect(dialog, &QFileDialog::filesSelected, this, [this](const QStringList& files) {
    for (const QString& file : files) load(file);
  });
  dialog->show();
}

void ComparisonController::load(const QString& file) {
  if (loader_.is_busy()) return waiting_.append(file);
  messages_.say(reading_text(run_name(file)), Severity::note);
  loader_.load(file.toStdString());
}

void ComparisonController::refresh() {
  if (auto run = loader_.take()) {
    if (!*run)
      messages_.problem(tr("This recording cannot be read"), QString::fromStdString(run->error()));
    else
      add(std::make_shared<const app::RecordedRun>(std::move(**run)));
    if (!waiting_.isEmpty()) load(waiting_.takeFirst());
  }
  if (others_.empty()) return;
  if (kicks_ && (!looked_.isValid() || looked_.hasExpired(kicks_ms))) {
    looked_.start();
    align(aligned_at_);
  }
  if (runs_.shown().latest()) arena_->set_others(others_at(runs_.shown().t()));
}

void ComparisonController::show_experiment() {
  const std::size_t robots = runs_.shown().experiment().robots.size();
  std::erase_if(others_, [&](const Run& run) { return run.recording->experiment.robots.size() != robots; });
  arena_->set_others({});
  show();
}

void ComparisonController::show() {
  std::vector<ComparisonBar::Run> legend;
  std::vector<PlotsPanel::Compared> drawn;
  for (const Run& run : others_) {
    legend.push_back({run.name, run.shown});
    drawn.push_back({&run.recording->rows, run.shift, run.shown});
  }
  plots_->comparison_bar().show_runs(legend);
  plots_->compare(drawn);
  arena_->set_others(others_at(runs_.shown().t()));
  emit compared();
}

/// `kick`: 0 for the start. Runs that have no kick to compare it with stay where they are.
void ComparisonController::align(int kick) {
  const std::vector<RunResults::Kick> own = kicks_ ? kicks_() : std::vector<RunResults::Kick>();
  std::vector<double> times;
  times.reserve(own.size());
  for (const RunResults::Kick& of : own) times.push_back(of.t);
  plots_->comparison_bar().show_kicks(times);
  aligned_at_ = kick <= static_cast<int>(own.size()) ? kick : 0;
  bool moved = false;
  for (Run& run : others_) {
    double shift = 0.0;
    if (aligned_at_ > 0) {
      const auto k = static_cast<std::size_t>(aligned_at_ - 1);
      const std::vector<RunResults::Kick> theirs = run.results->kicks();
      if (const auto other = counterparts(own, theirs)[k]) shift = own[k].t - theirs[*other].t;
    }
    moved = moved || shift != run.shift;
    run.shift = shift;
  }
  if (moved) show();
}

void ComparisonController::add(ReplayRun::Recording recording) {
  const std::size_t robots = runs_.shown().experiment().robots.size();
  QString name = run_name(QString::fromStdString(recording->file));
  if (recording->experiment.robots.size() != robots) {
    messages_.problem(
        tr("These runs cannot be compared"),
        tr("%1 has %2 robots, this experiment %3.").arg(name).arg(recording->experiment.robots.size()).arg(robots));
    return;
  }
  const auto same = std::count_if(others_.begin(), others_.end(),
                                  [&](const Run& run) { return run.recording->file == recording->file; });
  if (same > 0) name += QStringLiteral(" (%1)").arg(same + 1);
  auto results = std::make_shared<RunResults>(recording->experiment);
  for (const app::TickRecord& row : recording->rows) results->add_record(row);
  others_.push_back({std::move(recording), name, std::move(results)});
  looked_.invalidate();
  show();
  messages_.say(tr("Compared with %1: %2").arg(compared_letter(others_.size() - 1), name), Severity::note);
}

void ComparisonController::end() {
  others_.clear();
  waiting_.clear();
  aligned_at_ = 0;
  show();
}

void ComparisonController::compare_with_now() {
  auto run = std::make_shared<app::RecordedRun>();
  run->file = tr("the run before").toStdString();
  run->experiment = runs_.shown().experiment();
  for (const auto& row : runs_.shown().rows()) run->rows.push_back(*row);
  if (run->rows.empty()) return messages_.say(tr("There is no run yet to compare with"), Severity::notice);
  add(std::move(run));
}

/// The other runs' robots where they were at this time, and where they had come from.
std::vector<OtherRun> ComparisonController::others_at(double t) const {
  std::vector<OtherRun> all;
  for (std::size_t k = 0; k < others_.size(); ++k) {
    if (!others_[k].shown) continue;
    const auto& rows = others_[k].recording->rows;
    const double then = t - others_[k].shift;
    const auto row_at = [&](double when) {
      return std::partition_point(rows.begin(), rows.end(), [&](const app::TickRecord& row) { return row.t <= when; });
    };
    OtherRun other;
    other.number = k;
    other.trails.resize(rows.front().robots.size());
    for (auto row = row_at(then - ArenaScene::trail_seconds), to = row_at(then); row != to; ++row)
      for (std::size_t i = 0; i < other.trails.size() && row->phase != app::Phase::staging; ++i) {
        const app::RobotRecord& robot = row->robots[i];
        const core::Pose& pose = std::isfinite(robot.truth.x) ? robot.truth : robot.pose;
        if (std::isfinite(pose.x)) other.trails[i].push_back(pose);
      }
    all.push_back(std::move(other));
  }
  return all;
}

}  // namespace skein::ui
