#pragma once

#include <QComboBox>
#include <QElapsedTimer>
#include <QLabel>
#include <QPushButton>
#include <QWidget>
#include <optional>

#include "app/experiment/experiment.h"
#include "ui/base/eliding_label.h"
#include "ui/base/folding_button.h"
#include "ui/run/run_state.h"
#include "ui/status/time_line.h"

class QBoxLayout;
class QHBoxLayout;
class QVBoxLayout;

namespace skein::ui {

/// The controls of a run, its progress, and STOP.
class RunBar final : public QWidget {
  Q_OBJECT

 public:
  explicit RunBar(QWidget* parent = nullptr);
  void show_experiment(const app::Experiment& experiment);
  void show_record(const app::TickRecord& record) { time_line_->show_record(record); }
  void show_state(const RunState& state);
  void pick_speed(int steps);  ///< this many steps faster; negative: slower

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
  void resizeEvent(QResizeEvent*) override;

 private:
  static constexpr int tightest = 7;
  /// 0: shows everything; at higher values the time line moves below the buttons, their texts and the remaining time
  /// disappear one after the other, and the phase follows the time line. STOP always stays.
  void set_tightness(int tightness);
  void fit();
  void put(QWidget* widget, QBoxLayout* into, int place);
  void show_time();
  void dress();
  QString phase_text_of(const RunState& state);
  void show_go(const RunState& state);
  void show_rest(const RunState& state);

  QWidget* rest_;  // everything but STOP
  ElidingLabel *name_, *phase_;
  QLabel* time_;
  FoldingButton *go_, *new_run_, *record_;
  QPushButton *step_, *stop_;
  QComboBox* speed_;
  TimeLine* time_line_;
  QVBoxLayout* texts_;
  QHBoxLayout *beside_, *below_;  // the buttons' line and the one under it
  bool has_short_time_ = false;
  double t_ = 0.0;
  std::optional<double> end_;
  bool has_time_ = false;
  std::optional<RunState::Go> shown_go_;
  QElapsedTimer since_;
  double since_t_ = 0.0, pace_ = 1.0;  // how fast the experiment's time really goes
};

}  // namespace skein::ui
