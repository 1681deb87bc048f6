#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment.h"
#include "app/newest.h"
#include "app/session.h"
#include "app/session_clock.h"
#include "app/simulated_world.h"
#include "vision/calibration.h"
#include "vision/frame_source.h"
#include "vision/recorder.h"
#include "vision/synthetic_camera.h"
#include "vision/tracker.h"

namespace skein::app {

/// The tracker of an experiment looks for its robots' tags.
vision::TrackerOptions tracker_options(const Experiment& experiment);
/// What a frame showed becomes the newest measurement of each robot that was seen in it.
void take(std::span<const vision::TagPose> tags, const Experiment& experiment, std::span<core::Measurement> newest);

/// When a frame went through its stations. Session's clock; none: not known. [s]
struct FrameTimes {
  double captured_at = none;  ///< the camera's stamp
  double arrived_at = none;   ///< the driver handed it over
  double grey_at = none;      ///< the picture is in the tracker's hands
  double ready_at = none;     ///< its poses are known
};

/// The camera of an experiment with its tracker: frames in, the newest measured pose of each robot out. On the wall
/// clock it runs on a thread of its own; on the virtual one it looks when it is told to.
class CameraRig {
 public:
  static tl::expected<std::unique_ptr<CameraRig>, std::string> open(const Experiment& experiment, SessionClock& clock,
                                                                    SimulatedWorld& world, bool pictures);
  ~CameraRig();

  /// Keeps every frame, as the tracker got it, in a film. Before the first frame.
  tl::expected<void, std::string> keep(const std::string& path);
  /// Any thread.
  VideoStatus video() const;
  CameraStatus camera() const;

  /// Wall clock: starts the thread.
  void start();
  void end();
  /// Virtual clock: takes and works off one frame now.
  void look();

  /// Overwrites the measurement of every robot that was seen since, and says when; false: nothing new. The control
  /// thread's.
  bool newest(std::span<core::Measurement> measurements, FrameTimes& times) noexcept;
  /// Waits until the newest frame was ready at `since` or later, at most until `until`. Wall clock only; the control
  /// thread's. [s, session's clock]
  void wait_for_frame(double since, double until) noexcept;

  bool picture(Picture& out);
  std::array<double, 2> pixel(double x, double y) const;

  /// True once the camera has failed for good; then `reason` says why.
  bool failed() const noexcept { return failed_.load(std::memory_order_acquire); }
  const std::string& reason() const noexcept { return reason_; }

 private:
  CameraRig(const Experiment& experiment, SessionClock& clock, SimulatedWorld& world, vision::Calibration calibration,
            bool pictures);
  void thread(const std::stop_token& stop);
  bool capture();  // false: the stream is over or broken, reason_ says which
  void work_off();

  const Experiment& experiment_;
  SessionClock& clock_;
  SimulatedWorld& world_;
  vision::Calibration calibration_;
  vision::TagTracker tracker_;
  std::unique_ptr<vision::SyntheticCamera> synthetic_;
  std::unique_ptr<vision::FrameSource> source_;
  std::unique_ptr<vision::Recorder> recorder_;
  bool live_ = false;  // a camera that stamps its frames with CLOCK_MONOTONIC
  bool pictures_;

  vision::Frame frame_;
  std::vector<core::Pose> poses_;
  std::vector<vision::SyntheticTag> tags_;
  struct Sight {
    std::vector<core::Measurement> robots;
    FrameTimes times;
  };
  Sight seen_;  // by the camera's side
  Newest<Sight> sights_;
  std::atomic<double> ready_at_{-1e9};  // of the newest frame
  int ready_ = -1;                      // eventfd: rung for every frame that was worked off
  Newest<Picture> picture_;
  std::string reason_;
  std::atomic<bool> failed_{false}, ending_{false};
  std::jthread thread_;
};

}  // namespace skein::app
