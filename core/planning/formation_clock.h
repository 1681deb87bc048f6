#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "core/control/gains.h"
#include "core/planning/delay.h"
#include "core/reference/reference.h"

namespace skein::core {

/// The clock of a formation that waits: while one of its robots is on its way back, all references move on slowly, and
/// afterwards faster, until they are on time again. It never stands, since Theorem 1 requires a nonzero v_ref, and its
/// rate is continuous, so that references stay continuous too.
class FormationClock {
 public:
  static constexpr double slowly = 0.2;         ///< its rate while it waits
  static constexpr double longest_wait = 20.0;  ///< for a robot or for several, then it runs on [s]
  static constexpr double most_behind = 60.0;   ///< farther behind it waits for no robot [s]
  static constexpr double least_hurry = 0.02;   ///< if the references leave less for catching up, it never waits

  /// By how much it may run faster than the experiment's clock: a share of what (18f, g) leave beside the couplings,
  /// the rest of which is for the robots' errors. Never negative.
  static double hurry(const Gains& gains, const ReferenceDemand& demand) noexcept;

  /// `away`: a robot is on its way back at time t. It may run by `hurry` faster than the experiment's clock, and its
  /// rate changes by at most `slope` [1/s]. If couplings grow until `hurry` is too little, it stays as far behind as it
  /// is until there is room again. It keeps (18f, g) while they grow if they take what is left evenly, at most 0.3 of
  /// it in the first tick and at most `slope` in a second, as a share of the references' speed.
  void step(double t, bool away, double hurry, double slope) noexcept;
  void reset() noexcept { *this = {}; }

  double behind(double t) const noexcept { return delay_.at(t); }  ///< the experiment's clock [s]
  double rate(double t) const noexcept { return delay_.rate(t); }

 private:
  Delay delay_;
  bool waits_ = false;  // for a robot that has not come back since
  bool stays_ = false;  // as far behind as it is, because the couplings leave too little
  double until_ = 0.0;  // it waits at most [s]
  double hurry_ = 0.0;  // with which it catches up
  double left_ = 0.0;   // for it, at the latest step
};

/// References on the predicted clock of a formation: robots that share the clock keep the formation's distances.
class WaitingReference final : public Reference {
 public:
  /// The clock outlives it.
  WaitingReference(std::unique_ptr<const Reference> on_time, const FormationClock& clock)
      : on_time_(std::move(on_time)), clock_(&clock) {}

  std::size_t robots() const noexcept override { return on_time_->robots(); }
  using Reference::at;
  ReferencePoint at(std::size_t i, double t) const noexcept override;
  /// That of the references on time: the caller that steps the clock bounds what its hurry adds.
  ReferenceDemand demand(double k_y) const noexcept override { return on_time_->demand(k_y); }
  bool smooth() const noexcept override { return on_time_->smooth(); }
  std::vector<std::vector<Pose>> lines() const override { return on_time_->lines(); }

 private:
  std::unique_ptr<const Reference> on_time_;
  const FormationClock* clock_;
};

}  // namespace skein::core
