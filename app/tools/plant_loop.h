#pragma once

#include <functional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/session_clock.h"
#include "app/session/plant.h"

namespace skein::app {

/// The ticks of a tool that drives a plant's robots itself, without the control tick: measurements in, wheel speeds
/// out, once a period of the experiment. When a tick fails, every robot has been commanded to stop.
class PlantLoop {
 public:
  /// `keep_on` is called in every tick; false ends the loop.
  PlantLoop(Plant& plant, SessionClock& clock, const Experiment& experiment, std::function<bool()> keep_on);

  /// Waits for the next tick, takes what is new, and sends every robot its wheel speeds again. The error: it was ended,
  /// or a link or the camera was lost.
  tl::expected<void, std::string> tick();
  /// In force from the next tick on.
  void command(std::size_t robot, const core::WheelSpeeds& wheels) { wheels_[robot] = wheels; }
  void stand();

  /// The newest measurements of each tag of Plant::tags(): of all cameras, those of camera 1 first, and of any camera.
  std::span<const core::Measurement> by_camera() const noexcept { return by_camera_; }
  std::span<const core::Measurement> newest() const noexcept { return newest_; }
  /// Of a robot, as of the last tick.
  const LinkRecord& link(std::size_t robot) const { return records_[robot].link; }

 private:
  Plant& plant_;
  SessionClock& clock_;
  const double period_;
  std::function<bool()> keep_on_;
  std::vector<core::Measurement> by_camera_, newest_;
  std::vector<core::Pose> truth_;
  std::vector<core::WheelSpeeds> wheels_;
  std::vector<RobotRecord> records_;
  FrameTimes frame_;
  double next_tick_;
};

}  // namespace skein::app
