#pragma once

#include <vector>

#include "app/experiment/experiment.h"
#include "app/tick/tick_input.h"

namespace skein::app {

/// The input of a recorded tick: with it another tick gives the same commands, bit for bit.
class RecordedInput {
 public:
  explicit RecordedInput(const Experiment& experiment);
  /// `row`: of one run, in order. Valid until the next call.
  const TickInput& of(const TickRecord& row);

 private:
  const std::size_t cameras_;
  std::int64_t last_tick_ = 0;
  std::vector<core::Measurement> measurements_;
  std::vector<double> delays_;
  std::vector<LinkInput> links_;
  std::vector<OperatorCommand> commands_;
  std::vector<core::Twist> laws_;  // of a controller of the run's own
  TickInput input_;
};

}  // namespace skein::app
