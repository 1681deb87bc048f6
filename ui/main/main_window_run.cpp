// What the operator does with a run, but for STOP: start, pause, step, speed, record.
#include <QDateTime>
#include <QDir>
#include <QMenu>
#include <QRegularExpression>
#include <QStandardPaths>

#include "ui/main/main_window.h"
#include "ui/run/alert_strip.h"
#include "ui/run/event_log.h"
#include "ui/run/run_bar.h"
#include "ui/settings.h"

namespace skein::ui {

void MainWindow::connect_run() {
  connect(run_bar_, &RunBar::go, this, &MainWindow::go);
  connect(run_bar_, &RunBar::step, this, &MainWindow::step);
  connect(run_bar_, &RunBar::new_run, this, &MainWindow::new_run);
  connect(run_bar_, &RunBar::stop, this, &MainWindow::stop);
  connect(run_bar_, &RunBar::speed_wanted, this, &MainWindow::set_speed);
  connect(run_bar_, &RunBar::record_wanted, this, &MainWindow::record);
  connect(&live_, &LiveSession::starting, this, &MainWindow::record_if_wanted);
  connect(&live_, &LiveSession::recorded, this, [this](const QString& file, const QString& problem) {
    if (problem.isEmpty())
      note(tr("recorded %1").arg(file), Severity::good);
    else
      note(problem, Severity::alarm);
  });
  connect(&live_, &LiveSession::film_failed, this, [this](const QString& problem) {
    note(tr("the film of this run ends here, the run goes on: %1").arg(problem), Severity::alarm);
  });
  connect(&live_, &LiveSession::was_away, this, [this](double seconds) {
    note(tr("the window stood still for %1 s; the control loop did not").arg(seconds, 0, 'f', 1), Severity::warning);
  });
}

void MainWindow::build_run_menu(QMenu* run) {
  const auto action = [&](const QString& text, const QString& name, const QKeySequence& keys, auto&& slot) {
    QAction* made = run->addAction(text, this, slot);
    made->setObjectName(name);
    made->setShortcut(keys);
    return made;
  };
  go_action_ =
      action(tr("Start / &pause / resume"), QStringLiteral("go_action"), QKeySequence(tr("F5")), [this] { go(); });
  action(tr("One &tick on"), QStringLiteral("step_action"), QKeySequence(tr("F6")), [this] { step(); });
  action(tr("&Faster"), QStringLiteral("faster"), QKeySequence(tr("Ctrl+Up")), [this] { run_bar_->pick_speed(1); });
  action(tr("Sl&ower"), QStringLiteral("slower"), QKeySequence(tr("Ctrl+Down")), [this] { run_bar_->pick_speed(-1); });
  new_run_action_ = action(tr("&New run"), QStringLiteral("new_run_action"), QKeySequence::New, [this] { new_run(); });
  run->addSeparator();
  action(tr("&Record as CSV"), QStringLiteral("record_action"), QKeySequence(tr("Ctrl+R")),
         [this] { record(!records_); });
  run->addSeparator();
  // The keys stand in the text only: StopGuard takes them before any shortcut could.
  action(tr("STOP\tSpace, Esc"), QStringLiteral("stop_action"), {}, [this] { stop(); });
}

void MainWindow::note(const QString& text, Severity severity) {
  const app::TickRecord* record = live_.latest();
  log_->note(record ? record->t : 0.0, text, severity);
  alert_->say(text, severity);
}

void MainWindow::go() {
  if (player_.is_loaded()) {
    player_.is_playing() ? player_.pause() : player_.play();
    return show_replay();
  }
  switch (live_.phase()) {
    case app::Phase::ready:
      return start_if_ready(false);
    case app::Phase::running:
      return live_.pause();
    case app::Phase::paused:
      return live_.resume();
    case app::Phase::staging:
    case app::Phase::stopped:
    case app::Phase::finished:
      return;
  }
}

void MainWindow::step() {
  if (player_.is_loaded()) return player_.step(1);
  if (live_.phase() == app::Phase::running) return live_.pause();
  const QString problem = live_.step();
  if (!problem.isEmpty()) alert_->say(tr("No steps: %1").arg(problem), Severity::notice);
}

void MainWindow::set_speed(double speed) {
  if (player_.is_loaded()) {
    player_.set_speed(speed);
    return show_replay();
  }
  const QString problem = live_.set_speed(speed);
  if (!problem.isEmpty()) alert_->say(tr("No other speed: %1").arg(problem), Severity::notice);
  show_state();
}

void MainWindow::new_run() {
  const bool teaches = teaches_;
  // A replay that the window began with has no live experiment behind it: then its own is set up.
  open(app::Experiment(live_.experiment().robots.empty() ? shown_experiment() : live_.experiment()), false);
  teaches_ = teaches;
}

RunState MainWindow::run_state() const {
  if (player_.is_loaded()) {
    RunState state;
    state.replay = true;
    state.phase = player_.is_playing() ? app::Phase::running : app::Phase::paused;
    state.t = player_.t();
    state.speed = player_.speed();
    return state;
  }
  const app::TickRecord* record = live_.latest();
  RunState state;
  state.phase = live_.phase();
  state.t = record ? record->t : 0.0;
  state.busy = live_.is_open() ? record == nullptr : live_.is_busy();
  state.failed = !live_.is_open() && !live_.is_busy();
  state.real_time = live_.real_time_reason();
  state.speed = live_.speed();
  state.recording = live_.record_file();
  state.record_next = records_;
  return state;
}

QString MainWindow::recordings_directory() const {
  const QString usual =
      QDir(QStandardPaths::writableLocation(QStandardPaths::DocumentsLocation)).filePath(QStringLiteral("skein"));
  return settings().value(QStringLiteral("recordings"), usual).toString();
}

void MainWindow::record(bool on) {
  if (player_.is_loaded()) return;
  records_ = on;
  if (!on && !live_.record_file().isEmpty()) {
    const QString file = live_.record_file(), problem = live_.record_to({});
    note(problem.isEmpty() ? tr("recorded %1").arg(file) : problem,
         problem.isEmpty() ? Severity::good : Severity::alarm);
  }
  const bool under_way = live_.phase() == app::Phase::running || live_.phase() == app::Phase::paused;
  if (on && under_way) record_if_wanted();
  show_state();
}

QString MainWindow::close_session() {
  const QString problem = live_.close_now();
  if (!problem.isEmpty()) return problem;
  QStringList missing;
  for (std::size_t i = 0; i < live_.robots().size(); ++i)
    if (!live_.robots()[i].stop_acknowledged) missing << QString::number(i + 1);
  if (missing.isEmpty()) return tr("all robots have stopped");
  return tr("robot %1 has NOT acknowledged its stop and may still be driving: switch it off by hand")
      .arg(missing.join(QStringLiteral(", ")));
}

/// Every run has a file of its own, named after the experiment and the moment; empty: there is no place for it.
QString MainWindow::recording_path(const app::Experiment& experiment, const QString& ending) const {
  const QDir directory(recordings_directory());
  if (!directory.mkpath(QStringLiteral("."))) return {};
  QString name = QString::fromStdString(experiment.name);
  name.replace(QRegularExpression(QStringLiteral("[^\\w-]+")), QStringLiteral("_"));
  const QString stamp = QDateTime::currentDateTime().toString(QStringLiteral("yyyyMMdd-HHmmss"));
  QString file = directory.filePath(QStringLiteral("%1-%2%3").arg(name, stamp, ending));
  for (int k = 2; QFile::exists(file); ++k)
    file = directory.filePath(QStringLiteral("%1-%2-%3%4").arg(name, stamp).arg(k).arg(ending));
  return file;
}

void MainWindow::record_if_wanted() {
  if (!records_ || !live_.record_file().isEmpty()) return;
  const QString file = recording_path(live_.experiment(), QStringLiteral(".csv"));
  if (!file.isEmpty()) return record_to(file);
  records_ = false;
  show_problem(tr("The run is not recorded"), tr("%1 cannot be made.").arg(recordings_directory()));
}

void MainWindow::record_to(const QString& file) {
  const QString problem = live_.record_to(file);
  records_ = problem.isEmpty();
  if (problem.isEmpty())
    note(tr("recording to %1").arg(file), Severity::note);
  else
    show_problem(tr("The run is not recorded"), problem);
}

}  // namespace skein::ui
