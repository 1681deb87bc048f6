#include "ui/main/robot_controller.h"

#include <QPointF>
#include <algorithm>
#include <cmath>

#include "ui/arena/arena_scene.h"
#include "ui/robots/robot_buttons.h"

namespace skein::ui {

RobotController::RobotController(Runs& runs, const Messages& messages, RobotButtons* buttons, QObject* parent)
    : QObject(parent), runs_(runs), messages_(messages), buttons_(buttons) {
  connect(this, &RobotController::testing, buttons_, &RobotButtons::show_testing);
  connect(buttons_, &RobotButtons::hold, this, [this](int robot, bool hold) {
    messages_.tell(runs_.shown().hold_robot(static_cast<std::size_t>(robot), hold));
  });
  connect(buttons_, &RobotButtons::test, this, &RobotController::test);
  connect(&runs_.live(), &LiveRun::robot_tested, this, &RobotController::show_test);
  connect(&runs_.live(), &LiveRun::test_failed, this, [this](const QString& reason) {
    emit testing(false);
    messages_.note(reason, Severity::alarm);
  });
}

/// What stands where a robot is to be put, in words; empty: nothing does.
QString RobotController::in_the_way(int robot, const core::Pose& pose) const {
  const app::TickRecord* record = runs_.shown().latest();
  if (!record) return {};
  const auto moved = static_cast<std::size_t>(robot);
  for (std::size_t k = 0; k < record->robots.size(); ++k) {
    if (k == moved) continue;
    const core::Pose there = place(record->robots[k]);
    const double away = core::distance(pose, there), now = core::distance(place(record->robots[moved]), there);
    const std::vector<app::RobotSpec>& robots = runs_.shown().experiment().robots;
    const double need = robots[moved].radius + robots[k].radius;
    if (away < need && away < now)  // two that stand too near already may be turned, and moved apart
      return tr("Robot %1 was not moved: robot %2 is %3 cm away, and two robots need %4 cm")
          .arg(robot + 1)
          .arg(k + 1)
          .arg(100 * away, 0, 'f', 1)
          .arg(100 * need, 0, 'f', 1);
  }
  return {};
}

void RobotController::move(int robot, const core::Pose& pose) {
  if (const QString why = in_the_way(robot, pose); !why.isEmpty()) return messages_.say(why, Severity::warning);
  messages_.tell(runs_.shown().move_robot(static_cast<std::size_t>(robot), pose));
}

void RobotController::kick(int robot, QPointF velocity) {
  messages_.tell(runs_.shown().kick_robot(static_cast<std::size_t>(robot), velocity.x(), velocity.y()));
}

void RobotController::put_obstacle(int number, const core::Obstacle& obstacle) {
  messages_.tell(runs_.shown().put_obstacle(number, obstacle));
}

void RobotController::bring_to_places() {
  const app::TickRecord* record = runs_.live().latest();
  if (!record) return;
  const auto& robots = runs_.live().experiment().robots;
  if (!std::all_of(robots.begin(), robots.end(), [](const auto& robot) { return robot.simulated(); }))
    return messages_.tell(runs_.live().stage());
  for (std::size_t i = 0; i < record->robots.size(); ++i)
    messages_.tell(runs_.live().move_robot(i, record->robots[i].nominal.pose));
}

void RobotController::test(int robot) {
  const auto begun = runs_.live().test_robot(static_cast<std::size_t>(robot));
  if (!begun) return messages_.tell(begun);
  emit testing(true);
  messages_.note(tr("Robot %1 is tested: it turns its wheels a little").arg(robot + 1), Severity::notice);
}

void RobotController::show_test(const app::WheelCheck& test) {
  emit testing(false);
  QStringList lines{test.version.empty() ? tr("firmware: not reported") : QString::fromStdString(test.version)};
  const QString low = test.battery_low ? tr(", low: charge it") : QString();
  lines << (std::isfinite(test.battery) ? tr("battery %1 V").arg(test.battery, 0, 'f', 2) + low
                                        : tr("battery: not reported") + low);
  lines << tr("counters: left %1, right %2 steps").arg(test.left_steps).arg(test.right_steps);
  for (const std::string& fault : test.faults) lines << QString::fromStdString(fault);
  const bool well = test.faults.empty();
  const QString verdict = well ? tr("Robot %1 executes its commands").arg(test.robot + 1)
                               : tr("Robot %1 does NOT execute its commands").arg(test.robot + 1);
  messages_.note(verdict + QStringLiteral(": ") + lines.join(QStringLiteral("; ")),
                 well ? Severity::good : Severity::alarm);
  messages_.problem(verdict, tr("Results of the test:"), lines.join(QLatin1Char('\n')));
}

}  // namespace skein::ui
