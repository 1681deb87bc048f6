#pragma once

#include <QString>
#include <QWidget>
#include <vector>

#include "app/experiment.h"
#include "app/tick_record.h"

namespace skein::ui {

/// How far the run is, and what the file has in store for it: its perturbations and changes of gains.
class TimeLine final : public QWidget {
  Q_OBJECT

 public:
  explicit TimeLine(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record);
  QSize sizeHint() const override { return {320, 40}; }
  QSize minimumSizeHint() const override { return {140, 36}; }

 protected:
  void paintEvent(QPaintEvent*) override;
  bool event(QEvent*) override;

 private:
  struct Mark {
    double t;
    int robot;  // from 0; -1: a gain
    QString text;
  };
  double x(double t) const;

  double duration_ = 1.0, t_ = 0.0;
  std::vector<Mark> marks_;
};

}  // namespace skein::ui
