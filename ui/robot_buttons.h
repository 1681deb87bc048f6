#pragma once

#include <QPushButton>
#include <QWidget>
#include <set>

#include "app/session.h"

namespace skein::ui {

/// What can be done with the one robot that is selected.
class RobotButtons final : public QWidget {
  Q_OBJECT

 public:
  explicit RobotButtons(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record);
  void show_state(const std::vector<app::RobotStatus>& links, app::Phase phase, bool open);
  void select_robot(int robot);  ///< from 0; -1: none
  /// The robots that the operator has made to stand, from 0.
  const std::set<int>& held() const { return held_; }

 signals:
  void hold(int robot, bool hold);
  void connect_again();

 private:
  void dress();

  QPushButton *hold_, *connect_;
  std::vector<app::RobotSpec> specs_;
  std::vector<app::RobotStatus> links_;
  std::set<int> held_;
  int selected_ = -1;
  app::Phase phase_ = app::Phase::ready;
  bool open_ = false;
};

}  // namespace skein::ui
