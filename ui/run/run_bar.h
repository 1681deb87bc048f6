#pragma once

#include <QComboBox>
#include <QElapsedTimer>
#include <QLabel>
#include <QPushButton>
#include <QWidget>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "ui/run/time_line.h"

namespace skein::ui {

/// Where a run is, as the bar shows it.
struct RunState {
  app::Phase phase = app::Phase::ready;
  double t = 0.0;            ///< time of the experiment [s]
  bool busy = false;         ///< no session yet
  bool failed = false;       ///< none to be had
  bool replay = false;       ///< a recorded run: `phase` is running while it plays, paused else
  QString real_time;         ///< why it can neither be stepped nor go at another speed; empty: it can
  double speed = 1.0;        ///< asked for
  QString recording;         ///< the file; empty: nothing is recorded
  bool record_next = false;  ///< the next run will be
};

/// What the operator does with a run, where the run is, and STOP.
class RunBar final : public QWidget {
  Q_OBJECT

 public:
  explicit RunBar(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void take(const app::TickRecord& record) { time_line_->take(record); }
  void show_state(const RunState& state);
  void pick_speed(int steps);  ///< so many steps faster; negative: slower

  QPushButton* stop_button() const { return stop_; }
  TimeLine* time_line() const { return time_line_; }

 signals:
  void go();  ///< Start, Pause or Resume, whichever applies
  void step();
  void new_run();
  void stop();
  void speed_wanted(double speed);
  void record_wanted(bool on);

 protected:
  void changeEvent(QEvent*) override;

 private:
  void dress();
  QString phase_text_of(const RunState& state);
  void show_go(const RunState& state);
  void show_rest(const RunState& state);

  QLabel *name_, *phase_, *time_;
  QPushButton *go_, *step_, *new_run_, *record_, *stop_;
  QComboBox* speed_;
  TimeLine* time_line_;
  double duration_ = 0.0;
  QString look_;  // of the go button now
  QElapsedTimer since_;
  double since_t_ = 0.0, pace_ = 1.0;  // how fast the experiment's time really goes
};

}  // namespace skein::ui
