#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// What the operator does in a run and the experiment's own [[operator]] do not, as it goes on. Robots that stood
/// elsewhere at its start are put there at t = 0.
class ActionsDone {
 public:
  explicit ActionsDone(const Experiment& experiment);
  /// The next row of the run.
  void note(const TickRecord& row);
  const std::vector<OperatorAction>& all() const noexcept { return done_; }

 private:
  bool file_does(double t, const Event& event);
  void note_first_places(const TickRecord& first);

  Experiment experiment_;
  std::vector<OperatorAction> of_file_;  // each explains one event
  std::vector<OperatorAction> done_;
  bool first_ = true;
};

/// The text of the experiment with the operator's actions in a run of it as [[operator]] tables: `skein run` repeats
/// them at the same times. `rows`: of the run, in order. Robots that stood elsewhere at its start are put there at t =
/// 0.
std::string text_as_done(const Experiment& experiment, const std::vector<const TickRecord*>& rows);

/// The text with other gains in [controller.gains]: a number if all pairs have the same, else every pair's. The error
/// names the gain that cannot be written, and the reason.
tl::expected<std::string, std::string> text_with_gains(std::string text, const core::CouplingGains& gains);

}  // namespace skein::app
