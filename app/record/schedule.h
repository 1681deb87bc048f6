#pragma once

#include <memory>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// The places of the robots at a time of the experiment, as if the formation never waited: the `nominal` reference of a
/// formation that waits for one of its robots follows the formation's own clock.
class Schedule {
 public:
  explicit Schedule(const Experiment& experiment)
      : reference_(experiment.avoidance.formation_waits ? make_reference(experiment) : nullptr) {}

  core::Pose place(const TickRecord& record, std::size_t robot) const {
    return reference_ && record.lag > 0.0 ? reference_->at(robot, record.t).pose : record.robots[robot].nominal.pose;
  }

 private:
  std::unique_ptr<const core::Reference> reference_;
};

}  // namespace skein::app
