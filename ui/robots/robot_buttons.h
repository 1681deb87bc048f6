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
  struct State {
    std::vector<app::RobotStatus> links;
    std::set<int> held;  ///< from 0: made to stand by the operator
    app::Phase phase = app::Phase::ready;
    bool open = false, busy = false;  ///< busy: a session is being opened or closed
  };
  void show_state(const State& state);
  void show_testing(bool testing);
  void select_robot(int robot);  ///< from 0; -1: none

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
  State state_;
  int selected_ = -1;
  bool testing_ = false;
};

}  // namespace skein::ui
