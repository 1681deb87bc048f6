#pragma once

#include <QElapsedTimer>
#include <QObject>
#include <QTimer>
#include <memory>

#include "app/replay/replay.h"

namespace skein::ui {

/// Plays a recorded run: hands on its rows as time goes by, or those up to where the operator wants to be.
class Player final : public QObject {
  Q_OBJECT

 public:
  using Run = std::shared_ptr<const app::RecordedRun>;
  static constexpr double memory = 20.0;  ///< after a jump, so much of what came before is handed on again [s]

  explicit Player(QObject* parent = nullptr);
  void load(Run run);  ///< null: nothing to play
  const Run& run() const { return run_; }
  bool is_loaded() const { return run_ != nullptr; }

  void play();
  void pause();
  bool is_playing() const { return playing_; }
  void set_speed(double speed);
  double speed() const { return speed_; }
  void step(int ticks);  ///< so many rows on, or back
  void seek(double t);
  double t() const { return t_; }
  double first_time() const { return run_->rows.front().t; }
  double last_time() const { return run_->rows.back().t; }
  const app::TickRecord& latest() const { return run_->rows[next_ > 0 ? next_ - 1 : 0]; }
  /// The rows handed on so far.
  std::size_t next() const { return next_; }

 signals:
  void record_taken(const skein::app::TickRecord& record);  ///< in order; after a jump from 20 s before it on
  void moved();                                             ///< after every step, jump and frame in which time went by

 private:
  void look();
  void hand_on(std::size_t end);

  Run run_;
  std::size_t next_ = 0;  // the first row that was not handed on
  double t_ = 0.0, speed_ = 1.0;
  bool playing_ = false;
  QElapsedTimer since_;
  QTimer timer_;
};

}  // namespace skein::ui
