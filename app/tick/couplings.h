#pragma once

#include <optional>

#include "app/experiment/experiment.h"
#include "app/run/event.h"
#include "app/run/operator_command.h"

namespace skein::app {

/// The couplings of a run: what the file schedules and what the operator asks for, each approached by a ramp and held
/// where (18f, g) end. A pair can be switched off: its gains go to zero, are kept in mind, and come back with it.
/// Part of the tick: allocates in its constructor only.
class Couplings {
 public:
  Couplings(const Experiment& experiment, const core::Gains& gains, const core::ReferenceDemand& demand);

  /// What the operator asks for. Before the run (`ready`) it counts at once: there is no motion yet that a jump could
  /// disturb. `recorded`: of a run that is repeated, where the value has been held at its border already.
  void set(const commands::SetGain& command, bool ready, bool recorded, EventList& events) noexcept;
  void set(const commands::SetPairGain& command, bool ready, bool recorded, EventList& events) noexcept;
  void couple(const commands::Couple& command, bool ready, bool recorded, EventList& events) noexcept;
  /// What was changed before the run began belongs into its record, or it could not be repeated from it.
  void note_changes_before_start(EventList& events) const noexcept;
  /// The file's changes that are due at time t. [s]
  void follow_file(double t, EventList& events) noexcept;
  /// Goes on by dt [s] and puts the present values into `gains`: (18f, g) hold with them at every step.
  void step(double dt, core::Gains& gains) noexcept;

  const core::CouplingGains& now() const noexcept { return schedule_.now(); }
  const core::CouplingGains& target() const noexcept { return schedule_.target(); }
  bool coupled(std::size_t i, std::size_t j) const noexcept { return off_(i, j) == 0.0; }

 private:
  bool is_pair(std::size_t i, std::size_t j) const noexcept;
  void switch_on(std::size_t i, std::size_t j, bool ready, bool recorded, EventList& events) noexcept;
  void switch_off(std::size_t i, std::size_t j, bool ready, EventList& events) noexcept;
  /// The value that the pair may have where `recorded` does not say that it has it; notes where that is less than was
  /// asked for.
  double held(const commands::SetPairGain& asked, bool recorded, EventList& events) const noexcept;
  void go(core::GainName name, std::size_t i, std::size_t j, double value, bool ready, double seconds = 0.0) noexcept;
  double rate(core::GainName name, bool ready) const noexcept;
  /// A change of the file was checked with the file's other gains, not with the operator's: it is held where (18f, g)
  /// end beside these.
  void hold_file(const GainChange& change, EventList& events) noexcept;
  double base(core::GainName name, std::size_t i, std::size_t j) const noexcept;

  const std::vector<GainChange> changes_;
  const core::CouplingGains file_;
  const core::Gains limits_;  // v_max, omega_max and what is reserved to tracking
  const core::ReferenceDemand demand_;
  std::size_t next_change_ = 0;
  core::GainSchedule schedule_;
  core::CouplingGains wanted_;  // where the pairs would be going, were none switched off
  core::PairTable off_;         // 1: the pair is switched off
  bool any_off_ = false, shapes_change_ = false;
  bool asked_ = false;  // the operator has changed something
  std::array<std::optional<double>, 3> all_before_start_;
  core::PairTable scratch_;
};

}  // namespace skein::app
