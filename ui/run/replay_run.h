#pragma once

#include <QElapsedTimer>
#include <QStringList>
#include <QTimer>
#include <array>
#include <memory>
#include <set>

#include "app/replay/replay.h"
#include "core/control/gain_schedule.h"
#include "ui/run/run_source.h"

namespace skein::ui {

/// Plays a recorded run: shows its rows as time goes by, or those up to the time that the operator chose. Nothing in it
/// can be changed.
class ReplayRun final : public RunSource {
  Q_OBJECT

 public:
  using Recording = std::shared_ptr<const app::RecordedRun>;
  static constexpr double memory = 20.0;  ///< after a jump, this much of the preceding time is shown again [s]

  explicit ReplayRun(QObject* parent = nullptr);
  void load(Recording run);  ///< null: nothing to play
  const Recording& recording() const { return run_; }
  bool is_loaded() const { return run_ != nullptr; }
  /// Adds every row to the run, and shows the first.
  void begin();

  void play();
  void pause();
  bool is_playing() const { return playing_; }
  double speed() const { return speed_; }
  double first_time() const { return run_->rows.front().t; }
  double last_time() const { return run_->rows.back().t; }
  /// The result of replaying the run through the same tick, line by line.
  QStringList verdict() const;
  bool came_out_the_same() const { return run_->check.different == 0 && run_->check.warnings.empty(); }

  const app::Experiment& experiment() const override { return run_->experiment; }
  QString file() const override { return {}; }
  QString title() const override;
  app::Phase phase() const override { return playing_ ? app::Phase::running : app::Phase::paused; }
  RunState state() const override;
  const app::TickRecord* latest() const override { return &row(); }
  double t() const override { return t_; }
  RunHistory::Rows rows() const override;
  bool is_complete() const override { return true; }
  std::vector<Notice> findings() const override;
  const std::vector<app::RobotStatus>& robots() const override { return links_; }
  bool is_open() const override { return false; }
  bool is_busy() const override { return false; }
  bool is_before_start() const override { return false; }
  bool stop_asked() const override { return false; }
  const Circumstances& circumstances() const override { return circumstances_; }
  std::vector<std::size_t> may_be_driving() const override { return {}; }
  QString why_fixed() const override;
  Notice banner() const override;
  Notice lasting_alert() const override;

  double gain(core::GainName name, std::size_t i, std::size_t j) const override;
  double gain_target(core::GainName name, std::size_t i, std::size_t j) const override { return gain(name, i, j); }
  bool coupled(std::size_t i, std::size_t j) const override;
  double gain_limit(core::GainName name) const override;
  double gain_limit(core::GainName name, std::size_t i, std::size_t j) const override;
  double gain_limit_now(core::GainName name) const override { return gain_limit(name); }

  Done go() override;
  Done step() override;
  Done set_speed(double speed) override;
  bool seek(double t) override;
  Done set_gain(core::GainName, double, double) override { return refusal(); }
  Done set_gain(core::GainName, std::size_t, std::size_t, double, double) override { return refusal(); }
  const std::vector<app::LawParameter>& parameters() const override { return parameters_; }
  Done set_parameter(const std::string&, double) override { return refusal(); }
  Done couple(std::size_t, std::size_t, bool) override { return refusal(); }
  Done move_robot(std::size_t, const core::Pose&) override { return refusal(); }
  Done kick_robot(std::size_t, double, double) override { return refusal(); }
  Done hold_robot(std::size_t, bool) override { return refusal(); }
  Done put_obstacle(int, const core::Obstacle&) override { return refusal(); }

 signals:
  /// In time; before the rows that are shown again.
  void jumped(const skein::ui::Circumstances& circumstances);

 private:
  const app::TickRecord& row() const { return run_->rows[next_ > 0 ? next_ - 1 : 0]; }
  Done refusal() const;
  core::CouplingGains gains_now() const;
  void advance();
  void note_changes(const app::TickRecord& of);
  void show_until(std::size_t end);
  void take_links();

  Recording run_;
  core::ReferenceDemand demand_;         // of the whole reference
  std::vector<app::RobotStatus> links_;  // as far as the row has them
  // At the present moment, by the events until then:
  std::set<std::array<std::size_t, 2>> uncoupled_;  // i < j
  Circumstances circumstances_;
  std::vector<app::LawParameter> parameters_;
  std::size_t next_ = 0;  // the first row that was not shown
  double t_ = 0.0, speed_ = 1.0;
  bool playing_ = false;
  QElapsedTimer since_;
  QTimer timer_;
};

}  // namespace skein::ui
