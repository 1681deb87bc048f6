#pragma once

#include "ui/main/messages.h"

namespace skein::ui {

class RobotButtons;

/// One robot at a time: moved, kicked, held, tested.
class RobotController final : public QObject {
  Q_OBJECT

 public:
  RobotController(Runs& runs, const Messages& messages, RobotButtons* buttons, QObject* parent = nullptr);

  void move(int robot, const core::Pose& pose);
  void kick(int robot, QPointF velocity);  ///< [m/s]
  void put_obstacle(int number, const core::Obstacle& obstacle);
  /// Moves simulated robots to their starts, as by hand; if there are real ones, all robots drive there.
  void bring_to_places();

 signals:
  void testing(bool on);  ///< a robot turns its wheels

 private:
  QString in_the_way(int robot, const core::Pose& pose) const;
  void test(int robot);
  void show_test(const app::WheelCheck& test);

  Runs& runs_;
  const Messages& messages_;
  RobotButtons* buttons_;
};

}  // namespace skein::ui
