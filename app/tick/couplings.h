#pragma once

#include <optional>

#include "app/experiment/experiment.h"
#include "app/run/event.h"
#include "app/run/operator_command.h"

namespace skein::app {

/// The couplings of a run, and its tracking gains where the file gives them: changes scheduled by the file and commands
/// of the operator, each approached by a ramp and clamped at the limit of (18f, g). A pair can be switched off: its
/// gains go to zero, are remembered, and restored with it. Part of the tick: allocates in its constructor only.
class Couplings {
 public:
  Couplings(const Experiment& experiment, const core::Gains& gains, const core::ReferenceDemand& demand);

  /// The operator's command. Before the run (`ready`) it takes effect at once: there is no motion yet that a jump could
  /// disturb. `recorded`: from a repeated run, whose values have already been clamped.
  void set(const commands::SetGain& command, bool ready, bool recorded, EventList& events) noexcept;
  void set(const commands::SetPairGain& command, bool ready, bool recorded, EventList& events) noexcept;
  void couple(const commands::Couple& command, bool ready, bool recorded, EventList& events) noexcept;
  /// Ends the ramps of what was changed while robots drove to their starts: a run begins with the gains asked for.
  void finish_ramps() noexcept;
  /// Changes before the run must be in its record, so that it can be repeated from it.
  void note_changes_before_start(EventList& events) const noexcept;
  /// The file's changes that are due at time t. [s]
  void follow_file(double t, EventList& events) noexcept;
  /// Advances by dt [s] and writes the present values to `gains`: (18f, g) hold with them at every step.
  void step(double dt, core::Gains& gains) noexcept;

  const core::CouplingGains& now() const noexcept { return schedule_.now(); }
  const core::CouplingGains& target() const noexcept { return schedule_.target(); }
  bool coupled(std::size_t i, std::size_t j) const noexcept { return off_(i, j) == 0.0; }

 private:
  bool is_pair(std::size_t i, std::size_t j) const noexcept;
  void switch_on(std::size_t i, std::size_t j, bool ready, bool recorded, EventList& events) noexcept;
  void switch_off(std::size_t i, std::size_t j, bool ready, EventList& events) noexcept;
  /// The allowed value for the pair, unless `recorded`; records whether it is less than
  /// requested.
  double held(const commands::SetPairGain& asked, bool recorded, EventList& events) const noexcept;
  void go(core::GainName name, std::size_t i, std::size_t j, double value, bool ready, double seconds = 0.0) noexcept;
  double rate(core::GainName name, bool ready) const noexcept;
  /// A change of the file was checked with the file's other gains, not with the operator's: it is clamped at the limit
  /// of (18f, g) with these, and with the tracking gains that the file asks for by then.
  void hold_file(const GainChange& change, EventList& events) noexcept;
  void follow_tracking(const GainChange& change, EventList& events) noexcept;
  void reserve_for_file(const core::TrackingGains& tracking) noexcept;
  double base(core::GainName name, std::size_t i, std::size_t j) const noexcept;

  // Of the experiment.
  std::vector<GainChange> changes_;
  core::CouplingGains file_;
  core::Gains limits_;       // v_max, omega_max and the reserve for tracking, for the operator
  core::Gains file_limits_;  // the same for the file, which may use what it does not reserve at that time
  core::ReferenceDemand demand_;
  // What lasts from tick to tick.
  std::size_t next_change_ = 0;
  core::GainSchedule schedule_;
  core::TrackingSchedule tracking_;
  core::CouplingGains wanted_;  // the pairs' targets if none were switched off
  core::PairTable off_;         // 1: the pair is switched off
  bool any_off_ = false, shapes_change_ = false, tracking_changes_ = false;
  bool asked_ = false;  // the operator has changed something
  std::array<std::optional<double>, 3> all_before_start_;
  core::PairTable scratch_;
};

}  // namespace skein::app
