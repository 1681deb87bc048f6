// A recorded run through the same widgets, and a second run to compare with.
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QMenu>
#include <algorithm>
#include <cmath>
#include <utility>

#include "ui/arena/arena_view.h"
#include "ui/gains/gains_panel.h"
#include "ui/main/main_window.h"
#include "ui/plots/plots_panel.h"
#include "ui/robots/robot_buttons.h"
#include "ui/robots/robots_panel.h"
#include "ui/run/alert_strip.h"
#include "ui/run/check_list.h"
#include "ui/run/event_log.h"
#include "ui/run/run_bar.h"

namespace skein::ui {

void MainWindow::connect_replay() {
  connect(&player_, &Player::record_taken, this, [this](const app::TickRecord& record) {
    arena_->take(record);
    run_bar_->take(record);
  });
  connect(&player_, &Player::moved, this, &MainWindow::show_replay);
  connect(run_bar_->time_line(), &TimeLine::time_wanted, this, &MainWindow::seek);
  connect(plots_, &PlotsPanel::time_wanted, this, &MainWindow::seek);
  connect(log_, &EventPanel::time_picked, this, &MainWindow::seek);
}

void MainWindow::build_replay_menu(QMenu* file) {
  const auto action = [&](const QString& text, const QString& name, const QKeySequence& keys, auto&& slot) {
    QAction* made = file->addAction(text, this, slot);
    made->setObjectName(name);
    made->setShortcut(keys);
    return made;
  };
  const auto ask = [this](const QString& title, const QString& name, void (MainWindow::*then)(const QString&)) {
    auto* dialog = new QFileDialog(this, title, recordings_directory(), tr("Recorded runs (*.csv);;All files (*)"));
    dialog->setObjectName(name);
    dialog->setOption(QFileDialog::DontUseNativeDialog);  // so that Space and Esc reach the program
    dialog->setFileMode(QFileDialog::ExistingFile);
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->setWindowModality(Qt::NonModal);
    connect(dialog, &QFileDialog::fileSelected, this, then);
    dialog->show();
  };
  action(tr("Open &recording …"), QStringLiteral("open_recording"), QKeySequence(tr("Ctrl+Shift+O")), [this, ask] {
    ask(tr("Open recording"), QStringLiteral("open_recording_dialog"), &MainWindow::open_recording);
  });
  action(tr("&Compare with …"), QStringLiteral("compare"), QKeySequence(tr("Ctrl+D")),
         [this, ask] { ask(tr("Compare with"), QStringLiteral("compare_dialog"), &MainWindow::compare_with); });
  action(tr("Compare with this run as it is &now"), QStringLiteral("compare_now"), {}, [this] { compare_with_now(); });
  action(tr("&End the comparison"), QStringLiteral("compare_end"), {}, [this] { compare(nullptr); });
}

void MainWindow::open_recording(const QString& file) {
  if (!real_robots_move()) load(file, false);
}

void MainWindow::compare_with(const QString& file) {
  load(file, true);
}

/// Aside: half an hour is a hundred megabytes of numbers.
void MainWindow::load(const QString& file, bool to_compare) {
  if (loading_) return;
  alert_->say(tr("Reading %1 …").arg(QFileInfo(file).fileName()), Severity::note);
  loading_ = Loading{to_compare, std::async(std::launch::async, [file] { return app::load_run(file.toStdString()); })};
}

void MainWindow::take_loaded() {
  if (loading_ && loading_->run.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    const bool to_compare = loading_->to_compare;
    auto run = loading_->run.get();
    loading_.reset();
    if (!run)
      show_problem(tr("This recording cannot be read"), QString::fromStdString(run.error()));
    else if (to_compare)
      compare(std::make_shared<const app::RecordedRun>(std::move(*run)));
    else {
      remember_file(QString::fromStdString(run->file));
      waiting_ = std::make_shared<const app::RecordedRun>(std::move(*run));
    }
  }
  if (!waiting_ || live_.is_busy()) return;
  if (live_.is_open()) {
    arena_->set_camera(nullptr);  // it goes with the session
    live_.end();
    return;
  }
  start_replay(std::exchange(waiting_, nullptr));
}

void MainWindow::start_replay(const Player::Run& run) {
  player_.load(run);
  show_experiment_of(run->experiment);
  plots_->show_run(run->rows);
  run_bar_->time_line()->set_scrubbable(true, run->rows);
  const QString off = tr("A replay: nothing here can be changed. Back to the live experiment: Ctrl+N");
  checks_->hide();
  robot_buttons_->setEnabled(false);
  gains_->setEnabled(false);
  gains_->setToolTip(off);
  setWindowTitle(tr("%1 (replay) – Skein").arg(QFileInfo(QString::fromStdString(run->file)).fileName()));
  const app::ReplayResult& check = run->check;
  QStringList found;
  if (check.different == 0)
    found << tr("%1 commands come out bit for bit").arg(check.commands);
  else
    found << tr("%1 of %2 commands come out differently, first: %3")
                 .arg(check.different)
                 .arg(check.commands)
                 .arg(QString::fromStdString(check.first));
  for (const std::string& warning : check.warnings) found << QString::fromStdString(warning);
  const bool good = check.different == 0 && check.warnings.empty();
  alert_->hold(found.join(QStringLiteral("; ")), good ? Severity::good : Severity::warning);
  for (const QString& line : found) log_->note(run->rows.front().t, line, good ? Severity::good : Severity::warning);
  for (const app::TickRecord& row : run->rows) log_->take(row);
  player_.seek(run->rows.front().t);
  player_.play();
  show_replay();
}

void MainWindow::leave_replay() {
  player_.load(nullptr);
  run_bar_->time_line()->set_scrubbable(false, {});
  robot_buttons_->setEnabled(true);
  gains_->setEnabled(true);
  gains_->setToolTip({});
}

/// To a time of the run: a replay goes there, of a live run the plots do.
void MainWindow::seek(double t) {
  if (player_.is_loaded())
    player_.seek(t);
  else
    plots_->show_time(t);
}

void MainWindow::show_replay() {
  if (!player_.is_loaded()) return;
  const app::TickRecord& record = player_.latest();
  run_bar_->show_state(run_state());
  go_action_->setEnabled(true);
  new_run_action_->setEnabled(true);
  save_csv_action_->setEnabled(false);
  plots_->set_playhead(player_.t());
  gains_->take(record);
  std::array<double, 3> borders{};
  for (const core::GainName gain : core::gain_names)
    borders[static_cast<std::size_t>(gain)] = recorded_border(gain, record);
  const auto border = [&borders](core::GainName gain) { return borders[static_cast<std::size_t>(gain)]; };
  gains_->set_borders(border, border);
  show_couplings(borders,
                 [&record](core::GainName gain, std::size_t i, std::size_t j) { return record.pair_gain(gain, i, j); });
  arena_->set_banner(record.phase == app::Phase::paused ? tr("Replay – it was paused here") : tr("Replay"), false);
  arena_->set_hint({});
  std::vector<app::RobotStatus> links(record.robots.size());
  for (app::RobotStatus& link : links) {
    link.link = app::LinkState::recorded;
    link.stop_acknowledged = true;
  }
  robots_->robots().take(record, links, false, robot_buttons_->held());
  show_numbers(record);
  show_other(player_.t());
}

/// The border that (18f, g) left to a gain over the whole reference, with the others as they were.
double MainWindow::recorded_border(core::GainName gain, const app::TickRecord& record) const {
  const app::Experiment& experiment = player_.run()->experiment;
  const core::CouplingGains then{record.pair_gains[0], record.pair_gains[1], record.pair_gains[2]};
  const core::ReferenceDemand demand = app::make_reference(experiment)->demand(experiment.controller.k_y);
  return core::gain_border(gain, app::make_gains(experiment), then, demand);
}

void MainWindow::compare(const Player::Run& other) {
  if (other && other->experiment.robots.size() != shown_experiment().robots.size()) {
    show_problem(tr("These runs cannot be compared"),
                 tr("%1 has %2 robots, this experiment %3.")
                     .arg(QFileInfo(QString::fromStdString(other->file)).fileName())
                     .arg(other->experiment.robots.size())
                     .arg(shown_experiment().robots.size()));
    return;
  }
  other_ = other;
  plots_->compare(other ? &other->rows : nullptr);
  arena_->set_other(std::nullopt);
  if (other) alert_->say(tr("Pale: %1").arg(QFileInfo(QString::fromStdString(other->file)).fileName()), Severity::note);
  show_other(player_.is_loaded() ? player_.t() : live_.latest() ? live_.latest()->t : 0.0);
}

void MainWindow::compare_with_now() {
  auto run = std::make_shared<app::RecordedRun>();
  run->file = tr("the run before").toStdString();
  run->experiment = shown_experiment();
  if (player_.is_loaded())
    run->rows = player_.run()->rows;
  else
    for (const auto& row : live_.history().rows()) run->rows.push_back(*row);
  if (run->rows.empty()) return alert_->say(tr("There is no run yet to compare with"), Severity::notice);
  compare(run);
}

/// The other run's robots where they were at this time, and where they had come from.
void MainWindow::show_other(double t) {
  if (!other_) return;
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
  arena_->set_other(std::move(other));
}

const app::Experiment& MainWindow::shown_experiment() const {
  return player_.is_loaded() ? player_.run()->experiment : live_.experiment();
}

}  // namespace skein::ui
