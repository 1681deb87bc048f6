#pragma once

#include <QObject>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/session/session.h"
#include "ui/base/circumstances.h"
#include "ui/run/run_history.h"
#include "ui/run/run_state.h"

namespace skein::ui {

/// Updates the values of the law's parameters by this record's events; a recording may have more than its file
/// declares.
void note_parameters(const app::TickRecord& record, std::vector<app::LawParameter>& parameters);

/// A run as the window shows it, live or recorded: the experiment, its rows, its gains, and what the operator can do
/// with it. Code that shows a run uses only this interface.
class RunSource : public QObject {
  Q_OBJECT

 public:
  using Done = tl::expected<void, std::string>;  ///< the error says why it was refused

  explicit RunSource(QObject* parent = nullptr) : QObject(parent) {}

  virtual const app::Experiment& experiment() const = 0;
  /// The experiment's file; empty: there is none, or it is not known. A recording has its experiment inside.
  virtual QString file() const = 0;
  virtual QString title() const = 0;  ///< of the window
  virtual app::Phase phase() const = 0;
  virtual RunState state() const = 0;
  /// The record at the present moment; null: there is none yet.
  virtual const app::TickRecord* latest() const = 0;
  /// The present moment [s].
  virtual double t() const = 0;
  /// The rows that are kept: of a live run those so far, of a replay all.
  virtual RunHistory::Rows rows() const = 0;
  /// Whether all its rows are available from the beginning, so that it can seek to any time.
  virtual bool is_complete() const = 0;
  /// Findings from opening it, for the log.
  virtual std::vector<Notice> findings() const = 0;
  virtual const std::vector<app::RobotStatus>& robots() const = 0;
  /// How late its ticks have been so far; none: not known.
  virtual std::optional<app::Timing> timing() const { return {}; }
  virtual bool stop_asked() const = 0;                     ///< by the operator
  virtual const Circumstances& circumstances() const = 0;  ///< at the present moment
  /// The robots, from 0, that were commanded to stop and have not acknowledged it: they may be driving.
  virtual std::vector<std::size_t> may_be_driving() const = 0;

  /// A session is open, and its robots and gains can be acted on.
  virtual bool is_open() const = 0;
  /// A session is being opened or closed.
  virtual bool is_busy() const = 0;
  /// Whether it can be started, or could be once the failed checks are fixed.
  virtual bool is_before_start() const = 0;
  /// Why the operator cannot change anything here; empty: changes are possible.
  virtual QString why_fixed() const = 0;

  /// Across the arena; no text: nothing.
  virtual Notice banner() const = 0;
  /// The permanent text of the alert strip for this run; no text: none.
  virtual Notice lasting_alert() const = 0;

  // Gains of pairs i != j, from 0, at the present moment. `name` is one of core::gain_names.
  virtual double gain(core::GainName name, std::size_t i, std::size_t j) const = 0;
  virtual double gain_target(core::GainName name, std::size_t i, std::size_t j) const = 0;
  virtual bool coupled(std::size_t i, std::size_t j) const = 0;
  /// The limit of (18f, g): for all pairs over the whole reference, for one pair, for all pairs at the present moment
  /// alone. None: not known, since no session is open.
  virtual double gain_limit(core::GainName name) const = 0;
  virtual double gain_limit(core::GainName name, std::size_t i, std::size_t j) const = 0;
  virtual double gain_limit_now(core::GainName name) const = 0;

  /// What the law declares, with the values at the present moment.
  virtual const std::vector<app::LawParameter>& parameters() const = 0;

  virtual Done go() = 0;  ///< starts, pauses, resumes or plays, as `state().go` says
  virtual Done step() = 0;
  virtual Done set_speed(double speed) = 0;
  /// Goes to this time; false: the present moment cannot be moved.
  virtual bool seek(double t) = 0;
  /// `seconds`: of the ramp; 0: as fast as allowed.
  virtual Done set_gain(core::GainName name, double value, double seconds) = 0;
  virtual Done set_gain(core::GainName name, std::size_t i, std::size_t j, double value, double seconds) = 0;
  virtual Done set_parameter(const std::string& name, double value) = 0;
  virtual Done couple(std::size_t i, std::size_t j, bool on) = 0;
  virtual Done move_robot(std::size_t robot, const core::Pose& pose) = 0;
  virtual Done kick_robot(std::size_t robot, double vx, double vy) = 0;
  virtual Done hold_robot(std::size_t robot, bool hold) = 0;
  /// Number -1: a new one; radius 0: remove it.
  virtual Done put_obstacle(int number, const core::Obstacle& obstacle) = 0;

 signals:
  void row_added(const skein::app::TickRecord& record);     ///< to the run, in order
  void record_shown(const skein::app::TickRecord& record);  ///< the present moment has reached it
  void changed();  ///< the present moment was moved by the operator, or plays on
};

}  // namespace skein::ui
