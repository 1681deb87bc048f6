#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/run/operator_command.h"
#include "app/session/simulated_world.h"
#include "app/tick/control_tick.h"
#include "app/tick/recorded_input.h"

namespace skein::app {

/// What a run will do. It follows the run's records with a tick and a floor of its own, and computes ahead from there,
/// as often as requested. One thread at a time, never the control thread.
class Forecast {
 public:
  /// Why this experiment's future cannot be computed, if so.
  static std::optional<std::string> impossible(const Experiment& experiment);

  explicit Forecast(const Experiment& experiment);  ///< for which it is possible

  /// Every record of a session from its first on, those before the start and in pauses included, in order.
  void follow(const TickRecord& record);

  /// Whether it is the run itself that is computed: a simulation whose every record was followed. Its ticks then have
  /// the same bits, if they come at exactly their times. Otherwise robots drive from their present poses by the law's
  /// model (1): without noise, delay or slip.
  bool exact() const noexcept { return simulation_ && complete_; }

  /// The run's next `ticks` records, if `commands` are given before the first of them and nothing else is changed
  /// later; the file's own actions take place. A run that stands ready or paused is started or resumed. Fewer at the
  /// run's end; none if it is over, or if `keep_on`, called before every tick, returns false.
  std::vector<TickRecord> ahead(std::size_t ticks, std::span<const OperatorCommand> commands,
                                const std::function<bool()>& keep_on);

 private:
  void carry_out(const Event& event, SimulatedWorld& world) const;
  void measure(double now);
  void perturb(double t, TickInput& input);

  const Experiment experiment_;
  const bool simulation_;
  bool complete_ = true;
  TickRecord last_;
  bool begun_ = false;
  RecordedInput recorded_;
  ControlTick tick_, ahead_;
  SimulatedWorld world_, floor_ahead_;

  // While it looks ahead.
  std::vector<core::SimulatedRobot> models_;
  std::vector<core::Measurement> measurements_;
  std::vector<core::Pose> truth_;
  std::vector<OperatorCommand> commands_;
  std::size_t next_perturbation_ = 0, next_action_ = 0;
};

}  // namespace skein::app
