#pragma once

#include <QLabel>
#include <QPushButton>
#include <QWidget>

#include "app/experiment.h"
#include "app/tick_record.h"
#include "ui/time_line.h"

namespace skein::ui {

/// What the operator does with a run, where the run is, and STOP.
class RunBar final : public QWidget {
  Q_OBJECT

 public:
  explicit RunBar(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record) { time_line_->take(record); }
  /// `busy`: no session yet; `failed`: none to be had.
  void show_phase(app::Phase phase, double t, bool busy, bool failed);

  QPushButton* stop_button() const { return stop_; }

 signals:
  void go();  ///< Start, Pause or Resume, whichever applies
  void new_run();
  void stop();

 protected:
  void changeEvent(QEvent*) override;

 private:
  void dress();

  QLabel *name_, *phase_, *time_;
  QPushButton *go_, *new_run_, *stop_;
  TimeLine* time_line_;
  double duration_ = 0.0;
  QString look_;  // of the go button now
};

}  // namespace skein::ui
