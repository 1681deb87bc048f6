// What is looked at before a start, and how it is mended.
#include <fmt/format.h>

#include <QDir>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/experiment/experiment_file.h"
#include "ui/arena/arena_view.h"
#include "ui/calibration/calibration_dialog.h"
#include "ui/gains/gains_panel.h"
#include "ui/main/main_window.h"
#include "ui/run/alert_strip.h"
#include "ui/run/check_list.h"

namespace skein::ui {

void MainWindow::begin_checks() {
  certificate_.reset();
  gains_->show_delay_margin({});
  // Aside: a long run of many robots takes longer than a frame.
  certifying_ = std::async(std::launch::async, [experiment = live_.experiment()] { return app::certify(experiment); });
}

std::vector<app::Check> MainWindow::judge() {
  if (certifying_.valid() && certifying_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    certificate_ = certifying_.get();
  }
  show_delay();
  return app::readiness(live_.experiment(), certificate_ ? &*certificate_ : nullptr, live_.latest(), live_.robots());
}

/// How much delay the loops bear, and how much there is: from a pose's capture to the moment the wheels obey.
void MainWindow::show_delay() {
  if (!certificate_) return;
  const core::DelayMargin& margin = certificate_->delay.margin;
  double measured = 0.0;
  if (const app::TickRecord* record = live_.latest())
    for (const app::RobotRecord& robot : record->robots)
      if (robot.pose_age <= old_pose)  // what is bridged is another matter
        measured = std::max(measured, robot.pose_age + robot.actuation_delay);
  const QString bears =
      (margin.unbounded ? tr("margin over %1 ms") : tr("margin %1 ms")).arg(1000 * margin.delay, 0, 'f', 0);
  QString text =
      live_.latest() ? tr("Delay %1 ms, %2").arg(1000 * measured, 0, 'f', 0).arg(bears) : tr("Delay %1").arg(bears);
  if (!margin.unbounded) text += tr(" (robot %1)").arg(certificate_->delay.robot + 1);
  gains_->show_delay_margin(text, !margin.unbounded && measured > margin.delay);
}

void MainWindow::show_checks() {
  if (certificate_)
    show_delay();
  else
    judge();  // for the delay margin, also where nobody looks at the list
  const bool failed = !live_.is_open() && !live_.is_busy() && live_.failure();
  const bool before_start = failed || (live_.is_open() && live_.phase() == app::Phase::ready);
  if (!before_start) {
    checks_->setVisible(checks_action_->isChecked());
    if (checks_->isVisible()) checks_->show_checks(judge());
    return;
  }
  const std::vector<app::Check> checks = judge();
  checks_->show_checks(checks);
  const bool something_to_mend = std::any_of(
      checks.begin(), checks.end(), [](const app::Check& check) { return check.state == app::Check::State::fails; });
  checks_->setVisible(checks_action_->isChecked() || something_to_mend);
}

void MainWindow::start_if_ready(bool overrule) {
  if (testing_) return alert_->say(tr("Not started: a robot is being tested"), Severity::warning);
  if (certifying_.valid()) certifying_.wait();  // it has had since the opening; this is the last of it
  const std::vector<app::Check> checks = judge();
  if (app::may_start(checks) && (overrule || app::all_hold(checks))) return live_.start();
  checks_->show_checks(checks);
  checks_->show();
  for (const app::Check& check : checks) {
    if (check.state == app::Check::State::holds) continue;
    alert_->say(tr("Not started: %1").arg(QString::fromStdString(check.reason)), Severity::warning);
    return;
  }
}

void MainWindow::mend(app::Check::What what) {
  using What = app::Check::What;
  switch (what) {
    case What::camera:
      return calibrate_camera();
    case What::tags:
      if (picture_->isEnabled()) picture_->setChecked(true);
      return;
    case What::links:
      return new_run();
    case What::gains:
      gains_dock_->show();
      gains_dock_->raise();
      return;
    case What::batteries:
      robots_dock_->show();
      robots_dock_->raise();
      for (std::size_t i = 0; i < live_.robots().size(); ++i)
        if (live_.robots()[i].battery_low) return arena_->select(static_cast<int>(i));
      return;
    case What::reference:
      return edit(QString::fromStdString(shown_experiment().source), experiment_file_);
    case What::places:
      return bring_to_places();
  }
}

/// Simulated robots are put where they start, as by a hand; where there are real ones, everybody drives there.
void MainWindow::bring_to_places() {
  const app::TickRecord* record = live_.latest();
  if (!record) return;
  const auto& robots = live_.experiment().robots;
  if (!std::all_of(robots.begin(), robots.end(), [](const auto& robot) { return robot.simulated(); }))
    return live_.stage();
  for (std::size_t i = 0; i < record->robots.size(); ++i) tell(live_.move_robot(i, record->robots[i].nominal.pose));
}

/// What the lens of the experiment's camera does, with a board that somebody shows it.
void MainWindow::calibrate_camera() {
  const app::Experiment& experiment = live_.experiment();
  const app::CameraSpec& spec = experiment.camera;
  const app::CameraKind kind = spec.kind();
  const bool looks_at_nothing = kind == app::CameraKind::absent || kind == app::CameraKind::synthetic;
  app::CalibratedCamera camera{looks_at_nothing ? "v4l2:/dev/video0" : spec.source};
  for (const auto& [name, value] : {std::pair("exposure", spec.exposure), {"gain", spec.gain}, {"focus", spec.focus}})
    if (!std::isnan(value)) camera.settings.push_back(fmt::format("{}={}", name, value));
  const QString name = QString::fromStdString(spec.calibration);
  auto* dialog = new CalibrationDialog(camera,
                                       QDir(QString::fromStdString(experiment.directory))
                                           .filePath(name.isEmpty() ? QStringLiteral("camera.toml") : name),
                                       this);
  connect(dialog, &CalibrationDialog::camera_wanted, this, [this, dialog] {
    const bool has_it = live_.is_open() && live_.experiment().camera.kind() == app::CameraKind::live;
    const app::Phase phase = live_.phase();
    if (has_it && (phase == app::Phase::running || phase == app::Phase::paused || phase == app::Phase::staging))
      return dialog->refuse(tr("The run needs the camera: stop it first"));
    if (has_it) {
      note(tr("the experiment is ended: its camera is being calibrated"), Severity::notice);
      arena_->set_camera(nullptr);
      live_.end();
    }
    calibrating_ = dialog;
  });
  connect(dialog, &CalibrationDialog::saved, this,
          [this](const QString& file) { note(tr("calibration written to %1").arg(file), Severity::good); });
  dialog->show();
}

/// The same experiment with one key of its file changed ("key=value"), before its start.
void MainWindow::reopen_with(const QString& set) {
  if (!live_.is_open() || live_.phase() != app::Phase::ready) return;
  const app::Experiment& now = live_.experiment();
  auto changed = app::parse_experiment(now.source, now.name, {set.toStdString()});
  if (!changed) {
    show_problem(tr("This cannot be run"), QString::fromStdString(changed.error().front().message()));
    show_experiment();  // what the panels show is what holds
    on_opened();
    return;
  }
  changed->directory = now.directory;
  open(*changed, false);
}

}  // namespace skein::ui
