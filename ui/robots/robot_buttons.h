#pragma once

#include <QAction>
#include <QToolButton>
#include <QWidget>
#include <set>

#include "app/session/session.h"

namespace skein::ui {

/// What can be done with the one robot that is selected: as buttons, and as actions for the table's menu. What cannot
/// be done is off, and its tip says why.
class RobotButtons final : public QWidget {
  Q_OBJECT

 public:
  explicit RobotButtons(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record);
  /// `busy`: a session is being opened or closed.
  void show_state(const std::vector<app::RobotStatus>& links, app::Phase phase, bool open, bool busy);
  void show_testing(bool testing);
  void select_robot(int robot);  ///< from 0; -1: none
  /// The robots that the operator has made to stand, from 0.
  const std::set<int>& held() const { return held_; }

 signals:
  void hold(int robot, bool hold);
  void test(int robot);
  void connect_again();

 private:
  QAction* make(const QString& name);
  void dress();
  void dress_test();

  QAction *hold_, *test_, *connect_;
  std::vector<app::RobotSpec> specs_;
  std::vector<app::RobotStatus> links_;
  std::set<int> held_;
  int selected_ = -1;
  app::Phase phase_ = app::Phase::ready;
  bool open_ = false, busy_ = false, testing_ = false;
};

}  // namespace skein::ui
