#pragma once

#include <QString>
#include <QWidget>
#include <vector>

#include "app/experiment/experiment.h"
#include "ui/run/run_history.h"

namespace skein::ui {

/// The progress of the run, and the perturbations and changes of gains that its file schedules.
class TimeLine final : public QWidget {
  Q_OBJECT

 public:
  explicit TimeLine(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void show_record(const app::TickRecord& record);
  /// A click on it seeks to that time. `rows`: the whole run, for its length and its events.
  void set_scrubbable(bool on, const RunHistory::Rows& rows);
  void set_flat(bool flat);  ///< no higher than its marks
  QSize sizeHint() const override { return {320, flat_ ? flat_height : 40}; }
  QSize minimumSizeHint() const override { return {flat_ ? 140 : 320, flat_ ? flat_height : 36}; }

 signals:
  void time_wanted(double t);

 protected:
  void paintEvent(QPaintEvent*) override;
  void mousePressEvent(QMouseEvent*) override;
  void mouseMoveEvent(QMouseEvent*) override;
  void keyPressEvent(QKeyEvent*) override;
  bool event(QEvent*) override;

 private:
  struct Mark {
    double t;
    int robot;  // from 0; -1: a gain
    QString text;
  };
  double x(double t) const;
  double time_at(double x) const;

  double duration_ = 1.0, t_ = 0.0;
  std::vector<Mark> marks_;
  std::vector<double> events_;  // of a replay, where something happened
  static constexpr int flat_height = 20;
  bool scrubbable_ = false, flat_ = false;
};

}  // namespace skein::ui
