#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/controllers/own_controller.h"
#include "app/run/operator_command.h"
#include "app/session/simulated_world.h"
#include "app/tick/control_tick.h"
#include "app/tick/recorded_input.h"

namespace skein::app {

/// Computes what a run will do. It follows the run's records with a tick and a floor of its own, and computes ahead
/// from there, as often as requested. One thread at a time, never the control thread. The run's own controller takes no
/// part in a forecast: its later answers could change. A second process of it does, started anew for each forecast, so
/// that it remembers neither the run nor the previous forecast.
class Forecast {
 public:
  /// Why this experiment's future cannot be computed, if so.
  static std::optional<std::string> impossible(const Experiment& experiment);

  explicit Forecast(const Experiment& experiment);  ///< for which it is possible

  /// Every record of a session from its first on, those before the start and in pauses included, in order.
  void follow(const TickRecord& record);

  /// Whether it is the run itself that is computed: a simulation whose every record was followed. Its ticks then have
  /// the same bits, if they come at exactly their times, and if a controller of the user's own remembers nothing.
  /// Otherwise robots drive from their present poses by the law's model (1): without noise, delay or slip.
  bool exact() const noexcept { return simulation_ && complete_; }

  /// The run's next `ticks` records, if `commands` are given before the first of them and nothing else is changed
  /// later; the file's own actions take place. A run that stands ready or paused is started or resumed. Fewer at the
  /// run's end; none if it is over, or if `keep_on`, called before every tick, returns false. With a controller of the
  /// user's own, none if it was not prepared or failed: then `failure` says why.
  std::vector<TickRecord> ahead(std::size_t ticks, std::span<const OperatorCommand> commands,
                                const std::function<bool()>& keep_on);
  const std::string& failure() const noexcept { return failure_; }

  /// Starts the process that the next `ahead` needs, if it needs one and there is no fresh one. Waits until it is
  /// ready, or until `keep_on` returns false.
  void prepare(const std::function<bool()>& keep_on);
  /// Ends it. No process is left.
  void rest() noexcept { second_.reset(); }

 private:
  void carry_out(const Event& event, SimulatedWorld& world) const;
  void measure(double now);
  void perturb(double t, TickInput& input);
  bool ask_second(TickInput& input);

  const Experiment experiment_;
  const bool simulation_;
  bool complete_ = true;
  TickRecord last_;
  bool begun_ = false;
  RecordedInput recorded_;
  ControlTick tick_, ahead_;
  SimulatedWorld world_, floor_ahead_;

  // Of a controller of the user's own.
  std::unique_ptr<OwnController> second_;  // for the next question; null: not started
  bool second_asked_ = false;              // it is no longer fresh
  double second_spent_ = 0.0;              // in its answers to this question [s]
  std::vector<Event> changed_;             // the parameters, so far in the run
  std::string failure_;

  // While it looks ahead.
  std::vector<core::SimulatedRobot> models_;
  std::vector<core::Measurement> measurements_;
  std::vector<core::Pose> truth_;
  std::vector<OperatorCommand> commands_;
  std::size_t next_perturbation_ = 0, next_action_ = 0;
};

}  // namespace skein::app
