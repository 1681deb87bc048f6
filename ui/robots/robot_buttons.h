#pragma once

#include <QAction>
#include <QToolButton>
#include <QWidget>
#include <set>

#include "app/session/session.h"

namespace skein::ui {

/// The actions for the selected robot: as buttons, and for the table's menu. An action that is not possible is
/// disabled, and its tip says why.
class RobotButtons final : public QWidget {
  Q_OBJECT

 public:
  explicit RobotButtons(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  struct State {
    std::vector<app::RobotStatus> links;
    std::set<int> held;  ///< from 0: held by the operator
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
