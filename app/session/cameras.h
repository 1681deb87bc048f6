#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <tl/expected.hpp>

#include "app/session/camera_rig.h"

namespace skein::app {

/// All cameras over one floor: a CameraRig with a thread each. Their poses are fused by the control tick. The loss of
/// one does not affect the others.
class Cameras {
 public:
  /// As CameraRig::open.
  static tl::expected<std::unique_ptr<Cameras>, std::string> open(const Experiment& experiment, SessionClock& clock,
                                                                  SimulatedWorld& world, bool pictures,
                                                                  const std::vector<int>& wanted, bool await = false);

  /// Records the frames of each camera, in the files of film_paths. To be called before the first frame.
  tl::expected<void, std::string> keep(const std::string& path);
  /// As CameraRig's.
  void keep_crops(TagCrops* crops);
  void start();
  void end();
  /// As CameraRig's, of all; null: there is none.
  std::function<VideoStatus()> end_film();
  /// Virtual clock: each takes and processes a frame now. Of films, on any clock, those do whose next frame is of the
  /// same moment, by their own times.
  void process_frames();

  /// Overwrites the newest measurements: those of camera 1 first, as many of each. True if the leading camera has
  /// something new, with the times of its frame: the first one that has not failed. Control thread only.
  bool newest(std::span<core::Measurement> measurements, FrameTimes& times) noexcept;
  /// As CameraRig's, of the leading camera.
  void wait_for_frame(double since, double until) noexcept { lead().wait_for_frame(since, until); }
  void watch_for_frame(double since, double until) noexcept { lead().watch_for_frame(since, until); }
  bool picture(Picture& out) { return lead().picture(out); }
  std::array<double, 2> pixel(double x, double y) const { return lead().pixel(x, y); }
  /// Events: those of each camera, and which of several are lost or back. Control thread only.
  void tell(EventList& events) noexcept;

  /// Of all cameras: counts are sums, `up` if every one is. Any thread.
  VideoStatus video() const;
  vision::SourceStatus status() const;

  /// Why robots were seen by no camera. As CameraRig's.
  std::vector<UnseenTag> why_not_seen();
  /// By robot: why its tag was not seen when that was last looked for, by the camera that can tell most. Any thread.
  std::vector<UnseenTag> why_lost() const;
  /// Sentences about lost robots and cameras, each once. Any thread, one caller at a time.
  std::vector<std::string> alarms();
  /// Of all cameras: `known` if it is for each that is not lost, `moved` of the first one that moved, and the sentences
  /// of all. Any thread.
  MarksStatus marks() const;
  /// Number of frames in which the camera that has the fewest has looked for robots; of those that are not lost. Any
  /// thread.
  std::int64_t fewest_frames() const;
  /// Notices which of several cameras are lost or back. Not on the control thread; one caller at a time.
  void watch();
  /// Some of several cameras are lost, and others are not. Any thread.
  bool partly_down() const;
  /// Why there is no camera left; empty: there is one.
  std::string failure() const;

 private:
  struct Each {
    std::unique_ptr<CameraRig> rig;
    std::atomic<bool> lost{false};  // written by watch()
    bool told = false;              // the control thread's: what its events say
    bool film = false;              // or pictures, beside other cameras: without a thread of its own
  };
  Cameras(const Experiment& experiment, const SessionClock& clock)
      : experiment_(experiment), clock_(clock), all_(experiment.cameras()) {}
  CameraRig& lead() const noexcept;

  const Experiment& experiment_;
  const SessionClock& clock_;
  std::vector<Each> all_;  // one at least
  std::mutex mutex_;
  std::vector<std::string> alarms_;  // guarded by it
  std::jthread films_;               // takes the frames of several films
};

}  // namespace skein::app
