#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/session_clock.h"
#include "app/run/status.h"
#include "app/session/camera_findings.h"
#include "app/session/last_sights.h"
#include "app/session/newest.h"
#include "app/session/rendered_camera.h"
#include "app/session/simulated_world.h"
#include "app/session/tag_crops.h"
#include "vision/calibration/calibration.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/diagnosis/rate_watch.h"
#include "vision/diagnosis/repeat_watch.h"
#include "vision/diagnosis/stamp_watch.h"
#include "vision/frames/frame_source.h"
#include "vision/recording/recorder.h"
#include "vision/tracker/tracker.h"

namespace skein::app {

/// When a frame passed its stages. Session's clock; none: not known. [s]
struct FrameTimes {
  double captured_at = none;  ///< by the camera's stamp and camera.latency
  double arrived_at = none;   ///< the driver delivered it
  double grey_at = none;      ///< the grey image has reached the tracker
  double ready_at = none;     ///< its poses are known
};

/// When a source that has no clock of its own gives a frame on the wall clock: once a period, half a period out of step
/// with the control thread, as far as a camera without a trigger can be.
class CameraPace {
 public:
  /// `period`: of the ticks [s]
  CameraPace(const SessionClock& clock, double period)
      : clock_(clock), period_(period), deadline_(clock.now() + 0.5 * period) {}
  /// Sleeps until the next frame is due; what is missed is left out.
  void wait();

 private:
  const SessionClock& clock_;
  double period_, deadline_;  // [s]
};

/// One camera of an experiment with its tracker: frames in, the newest measured pose of each robot out. On the wall
/// clock it runs on a thread of its own; on the virtual one it takes a frame on request.
class CameraRig {
 public:
  /// `wanted`: the tags to look for. `await`: a real camera that cannot be opened is retried every second. `number`: of
  /// the camera, from 0; `sights`: those of all cameras, if there are more.
  static tl::expected<std::unique_ptr<CameraRig>, std::string> open(const Experiment& experiment, SessionClock& clock,
                                                                    SimulatedWorld& world, bool pictures,
                                                                    std::vector<int> wanted, bool await = false,
                                                                    std::size_t number = 0,
                                                                    std::shared_ptr<LastSights> sights = nullptr);
  ~CameraRig();

  /// Records every frame of the tracker in a film. To be called before the first frame.
  tl::expected<void, std::string> keep(const std::string& path);
  /// Gives these a picture of each tag that is not seen; they must outlive it. To be called before the first frame.
  void keep_crops(TagCrops* crops) { findings_.keep_crops(crops); }
  /// Ends the film. The returned function completes the file, on any thread, even when the rig is gone; null: there is
  /// no film any more.
  std::function<VideoStatus()> end_film();
  /// Any thread.
  VideoStatus video() const;
  vision::SourceStatus camera() const;
  /// Events: the film has broken off, once; why a robot has not been seen for half a second; the marks on the floor
  /// show that the camera moved. Control thread only.
  void tell(EventList& events) noexcept;

  /// Wall clock: starts the thread; not `alone`: without it, process_frame is called instead.
  void start(bool alone = true);
  void end();
  /// Virtual clock, or not alone: takes and processes one frame; one of a film counts as captured at `now`. [s]
  void process_frame(double now);
  /// Films and pictures: the time of the next frame by its own film, which is read unless it has been [s]; none: the
  /// stream has ended or failed.
  std::optional<double> next_in_film();

  /// Overwrites the measurement of every wanted tag that was seen since, as far as there is room, and returns the
  /// times; false: nothing new. Control thread only.
  bool newest(std::span<core::Measurement> measurements, FrameTimes& times) noexcept;
  /// Waits until the newest frame was ready at `since` or later, at most until `until`. Wall clock only; control thread
  /// only. [s, session's clock]
  void wait_for_frame(double since, double until) noexcept;
  /// The same without sleeping, for a frame that is due at any moment. A sleeping thread is woken by an interrupt from
  /// the camera's processor to its own; in a virtual machine this takes some 20 us longer than its own timer, plus any
  /// delay of that interrupt. Wall clock only; control thread only. [s, session's clock]
  void watch_for_frame(double since, double until) const noexcept;

  /// Why robots' tags were not seen in the next frame; none: all were seen, or no frame came for a second. A robot that
  /// another camera has seen within the bridge time is not missing. Takes up to some seconds. Wall clock only; not on
  /// the control thread, one caller at a time.
  std::vector<UnseenTag> why_not_seen();

  /// By robot: why its tag was not seen when that was last looked for, in the background. A robot that was
  /// never seen is looked for every few seconds, others when they are lost. Wall clock only; any thread.
  std::vector<UnseenTag> why_lost() const { return findings_.why_lost(); }

  /// Sentences about lost robots, as from `why_not_seen`, about marks on the floor and about the tags' size, each once.
  /// Any thread, one caller at a time.
  std::vector<std::string> alarms() { return findings_.alarms(); }
  /// Any thread.
  MarksStatus marks() const { return findings_.marks(); }
  /// Number of frames in which it has looked for robots. Any thread.
  std::int64_t frames() const noexcept { return frames_.load(std::memory_order_relaxed); }

  bool picture(Picture& out);
  std::array<double, 2> pixel(double x, double y) const;

  /// True once the camera has failed for good; then `reason` says why.
  bool failed() const noexcept { return failed_.load(std::memory_order_acquire); }
  const std::string& reason() const noexcept { return reason_; }

 private:
  CameraRig(const Experiment& experiment, std::size_t number, SessionClock& clock, vision::Calibration calibration,
            bool pictures, std::vector<int> wanted, std::shared_ptr<LastSights> sights);
  void thread(const std::stop_token& stop);
  tl::expected<void, std::string> open_source();
  void await_source(const std::stop_token& stop);
  bool step(double now);     // takes and processes a frame; false: the camera has failed
  bool capture(double now);  // false: the stream has ended or failed, see reason_
  bool render();
  bool read();
  bool receive(double now);
  void work_off();
  void judge_frame();
  bool repeats();
  std::string never_seen() const;  // empty: all have been seen
  void answer_question();
  void watch_source();
  void film_frame(std::string note);

  const Experiment& experiment_;
  const CameraSpec& spec_;
  const std::size_t number_;
  const std::string prefix_;  // of its messages
  SessionClock& clock_;
  vision::Calibration calibration_;
  std::vector<int> wanted_;
  std::shared_ptr<LastSights> last_sights_;
  std::vector<vision::SeenElsewhere> elsewhere_;  // in this frame
  vision::TagTracker tracker_;
  CameraFindings findings_;
  std::unique_ptr<RenderedCamera> rendered_;     // null: not synthetic
  std::unique_ptr<vision::FrameSource> source_;  // null: synthetic, or not open yet
  std::atomic<bool> awaited_{false};             // a real camera that has not opened yet; then the thread owns source_
  std::string why_awaited_;                      // set before the thread begins
  std::shared_ptr<vision::Recorder> recorder_;
  std::mutex film_mutex_;  // held from a frame's poses until it is in the film; otherwise only the caller that ends the
                           // film takes it
  bool film_ended_ = false;    // under the mutex; the caller that ended it completes it
  bool told_of_film_ = false;  // the control thread's
  bool live_ = false;          // a camera that stamps its frames with CLOCK_MONOTONIC
  bool pictures_;

  vision::Frame frame_;
  bool read_ahead_ = false;  // the film's next frame is in it
  struct Sight {
    std::vector<core::Measurement> tags;
    FrameTimes times;
  };
  Sight seen_;  // written by the camera's thread
  Newest<Sight> sights_;
  std::atomic<double> ready_at_{core::Measurement::never};  // of the newest frame
  std::atomic<std::int64_t> frames_{0};
  int ready_ = -1;  // eventfd: signalled for every processed frame
  Newest<Picture> picture_;
  struct Question {
    vision::Frame frame;
    std::vector<vision::MissingTag> missing;
  };
  std::mutex question_mutex_;  // of what follows
  std::condition_variable answered_;
  bool asked_ = false;  // the next frame is requested
  Question answer_;
  vision::RateWatch rate_watch_;
  vision::RepeatWatch repeat_watch_;
  vision::StampWatch stamp_watch_;
  bool fits_ = true;                      // the last frame is of the calibration's size
  std::atomic<std::int64_t> freezes_{0};  // times that the picture was frozen
  std::atomic<bool> frozen_{false};       // it is
  std::atomic<double> frozen_part_{1.0};  // of its height, when it was last frozen
  mutable std::mutex unusable_mutex_;
  std::string unusable_;  // why no robot can drive by this camera's frames; empty: it can
  std::string reason_;
  std::atomic<bool> failed_{false}, ending_{false};
  std::jthread thread_;
};

}  // namespace skein::app
