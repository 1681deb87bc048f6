// What is looked at before a start, and how it is mended.
#include <algorithm>
#include <chrono>

#include "app/experiment_file.h"
#include "ui/alert_strip.h"
#include "ui/check_list.h"
#include "ui/gains_panel.h"
#include "ui/help.h"
#include "ui/main_window.h"

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
    const core::DelayMargin& margin = certificate_->delay.margin;
    const QString least = tr("%1 s").arg(margin.delay, 0, 'f', 2);
    gains_->show_delay_margin(tr("Delay margin: %1 (robot %2)")
                                  .arg(margin.unbounded ? tr("more than %1").arg(least) : least)
                                  .arg(certificate_->delay.robot + 1));
  }
  return app::readiness(live_.experiment(), certificate_ ? &*certificate_ : nullptr, live_.latest(), live_.robots());
}

void MainWindow::show_checks() {
  if (!certificate_) judge();  // for the delay margin, also where nobody looks at the list
  const bool before_start = live_.is_open() && live_.phase() == app::Phase::ready;
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
      return show_problem(tr("How to calibrate the camera"), calibration_text());
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
    case What::reference:
      return;
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
