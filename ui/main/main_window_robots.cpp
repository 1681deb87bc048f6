// One robot at a time: select, hold, test, connect; and what has to be known of robots with links.
#include <cmath>

#include "ui/arena/arena_view.h"
#include "ui/main/main_window.h"
#include "ui/robots/robot_buttons.h"
#include "ui/robots/robots_panel.h"
#include "ui/run/alert_strip.h"
#include "ui/run/event_log.h"

namespace skein::ui {

void MainWindow::connect_robots() {
  robots_->addActions(robot_buttons_->actions());
  robots_->setContextMenuPolicy(Qt::ActionsContextMenu);
  connect(robots_, &RobotsPanel::picked, arena_, &ArenaView::select);
  connect(robot_buttons_, &RobotButtons::hold, this,
          [this](int robot, bool hold) { tell(live_.hold_robot(static_cast<std::size_t>(robot), hold)); });
  connect(robot_buttons_, &RobotButtons::test, this, &MainWindow::test_robot);
  connect(robot_buttons_, &RobotButtons::connect_again, this, &MainWindow::new_run);
  connect(&live_, &LiveSession::robot_tested, this, &MainWindow::show_test);
  connect(&live_, &LiveSession::test_failed, this, [this](const QString& reason) {
    robot_buttons_->show_testing(testing_ = false);
    note(reason, Severity::alarm);
  });
}

void MainWindow::test_robot(int robot) {
  const auto begun = live_.test_robot(static_cast<std::size_t>(robot));
  if (!begun) return tell(begun);
  robot_buttons_->show_testing(testing_ = true);
  note(tr("Robot %1 is tested: it turns its wheels a little").arg(robot + 1), Severity::notice);
}

void MainWindow::show_test(const app::WheelCheck& test) {
  robot_buttons_->show_testing(testing_ = false);
  QStringList lines{test.version.empty() ? tr("firmware: not said") : QString::fromStdString(test.version)};
  const QString low = test.battery_low ? tr(", low: charge it") : QString();
  lines << (std::isfinite(test.battery) ? tr("battery %1 V").arg(test.battery, 0, 'f', 2) + low
                                        : tr("battery: no number said") + low);
  lines << tr("counters: left %1, right %2 steps").arg(test.left_steps).arg(test.right_steps);
  for (const std::string& fault : test.faults) lines << QString::fromStdString(fault);
  const bool well = test.faults.empty();
  const QString verdict = well ? tr("Robot %1 does as it is told").arg(test.robot + 1)
                               : tr("Robot %1 does NOT do as it is told").arg(test.robot + 1);
  note(verdict + QStringLiteral(": ") + lines.join(QStringLiteral("; ")), well ? Severity::good : Severity::alarm);
  show_problem(verdict, tr("What the test has found:"), lines.join(QLatin1Char('\n')));
}

/// Nothing would stop the robots should this program be killed: the operator has to know.
void MainWindow::warn_unguarded() {
  const auto why = live_.unguarded();
  if (!why) return;
  const QString text = tr("NO GUARD: should this program be killed, nothing stops the robots (%1)").arg(*why);
  log_->note(0.0, text, Severity::warning);
  alert_->warn_unguarded(text);
}

}  // namespace skein::ui
