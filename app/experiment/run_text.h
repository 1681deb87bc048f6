#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// Collects, row by row, the operator's actions in a run that the experiment's own [[operator]] tables do not contain.
/// Robots that were elsewhere at the start of the run are moved there at t = 0.
class ActionsDone {
 public:
  explicit ActionsDone(const Experiment& experiment);
  /// The next row of the run.
  void note(const TickRecord& row);
  const std::vector<OperatorAction>& all() const noexcept { return done_; }

 private:
  bool file_does(double t, const Event& event);
  void note_first_places(const TickRecord& first);
  void note_places(const TickRecord& row);
  Event repeatable(const TickRecord& row, const Event& event) const;

  Experiment experiment_;
  std::vector<OperatorAction> of_file_;  // each explains one event
  std::vector<OperatorAction> done_;
  bool first_ = true;
  bool stands_ = false;                       // the row is not the first of its time: the run pauses
  double t_ = 0.0;                            // of the latest places [s]
  std::vector<core::Pose> places_, earlier_;  // true ones, at t_ and a tick earlier
};

/// The text of the experiment with the operator's actions in a run of it as [[operator]] tables: `skein run` repeats
/// them at the same times; those of its text that it no longer has are left out. `rows`: of the run, in order. Robots
/// that were elsewhere at the start of the run are moved there at t = 0.
std::string text_as_done(const Experiment& experiment, const std::vector<const TickRecord*>& rows);

/// The text with other gains in [controller.gains]: one number if it is the same for all pairs, otherwise one for each
/// pair. The error names the gain that cannot be written, and the reason.
tl::expected<std::string, std::string> text_with_gains(std::string text, const core::CouplingGains& gains);

}  // namespace skein::app
