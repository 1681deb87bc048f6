#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/event.h"
#include "app/run/status.h"
#include "app/session/last_sights.h"
#include "app/session/tag_crops.h"
#include "vision/calibration/calibration.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/diagnosis/focus_watch.h"
#include "vision/diagnosis/mark_watch.h"
#include "vision/diagnosis/scale_watch.h"
#include "vision/diagnosis/tag_absence.h"
#include "vision/tracker/tracker.h"

namespace skein::app {

/// Why the frames of a camera cannot be used: they are of another size than the calibration holds for; empty: they can.
std::string size_fault(const vision::Frame& frame, const vision::Calibration& calibration);

/// What a camera's frames show beside poses, as sentences for the operator and as events: why robots' tags are not
/// seen, whether the camera has moved, whether tags are as large and as sharp as they should be. On the wall clock
/// frames are searched in a thread of its own, at a low priority; on the virtual one at once.
class CameraFindings {
 public:
  /// All of these must outlive it; `wanted` begins with the robots' tags.
  CameraFindings(const Experiment& experiment, std::size_t number, const vision::Calibration& calibration,
                 std::span<const int> wanted, const vision::TagTracker& tracker, const LastSights& sights,
                 bool wall_clock);
  ~CameraFindings() { end(); }
  CameraFindings(const CameraFindings&) = delete;
  CameraFindings& operator=(const CameraFindings&) = delete;

  /// Gives these a picture of each tag that is not seen; they must outlive it. To be called before the first frame.
  void keep_crops(TagCrops* crops) { crops_ = crops; }
  /// Wall clock: starts and ends the thread.
  void start();
  void end();

  // The camera's thread, after each frame. `tags`: the newest measurement of each wanted tag; `elsewhere`: where other
  // cameras see robots now.
  void watch_absences(const vision::Frame& frame, std::span<const core::Measurement> tags,
                      std::span<const vision::SeenElsewhere> elsewhere);
  void watch_marks(const vision::Frame& frame);
  void watch_tags(double captured_at);
  /// Those of the camera itself, each once.
  void tell_once(std::span<const std::string> sentences);
  /// A sentence for the operator.
  void tell(std::string sentence);
  /// What is known of a tag that is missing in this frame.
  vision::MissingTag missing_tag(std::size_t robot, const core::Measurement& newest) const;

  /// Why these tags are not seen in a frame; takes up to some seconds. Any thread.
  std::vector<UnseenTag> why_not_seen(const vision::Frame& frame, std::span<const vision::MissingTag> missing) const;
  /// By robot: why its tag was not seen when that was last looked for. Any thread.
  std::vector<UnseenTag> why_lost() const;
  /// What is to be told to the operator, each once. Any thread, one caller at a time.
  std::vector<std::string> alarms();
  /// Any thread.
  MarksStatus marks() const;
  /// The next event, if there is one. Control thread only.
  bool take(Event& found) noexcept { return found_.pop(found); }

 private:
  struct Question {
    vision::Frame frame;
    std::vector<vision::MissingTag> missing;
    std::set<int> seen_elsewhere{};  // of these tags: by another camera, where this one looks as well
  };
  std::size_t robot_of(int tag) const;
  UnseenTag unseen_tag(const vision::Frame& frame, const vision::TagDiagnosis& tag) const;
  void expect_here(const vision::Frame& frame, std::span<const core::Measurement> tags,
                   std::span<const vision::SeenElsewhere> elsewhere);
  void explain(const Question& question, const std::stop_token& stop = {});
  void tell_why(const Question& question, const std::vector<UnseenTag>& unseen);
  void tell_of_seen_elsewhere(const UnseenTag& tag);
  void look_at_marks(const vision::Frame& frame, bool may_search);
  void look_at_own_marks(const vision::Frame& frame, bool may_search);
  std::string why_marks_are_missing(const vision::Frame& frame, bool may_search);
  std::optional<std::size_t> whose_marks(const vision::Frame& frame) const;
  void thread(const std::stop_token& stop);
  events::CameraMoved moved() const;  // this camera

  const Experiment& experiment_;
  const std::size_t number_;
  const std::string prefix_;  // of its sentences
  const vision::Calibration& calibration_;
  const std::span<const int> wanted_;
  const vision::TagTracker& tracker_;  // the camera's thread only
  const LastSights& sights_;
  const bool wall_clock_;
  TagCrops* crops_ = nullptr;

  // The camera's thread's.
  std::vector<vision::TagAbsence> absences_;         // of the robots' tags
  double next_absence_ = none, next_search_ = none;  // the latter for robots that were never seen
  std::vector<vision::MissingTag> missing_;
  struct Expected {  // where this camera should see a robot, by what another one sees; none: nowhere
    std::optional<core::Pose> pose;
    vision::TagAbsence absence;
  };
  std::vector<Expected> expected_;  // by robot; none: there is one camera
  std::set<int> seen_elsewhere_;    // of the missing tags
  vision::ScaleWatch scale_watch_;
  vision::FocusWatch focus_watch_;
  int own_looks_ = 0;  // at the marks, not left to the thread
  bool looks_for_marks_ = false;
  std::set<std::string> told_once_;

  vision::MarkWatch mark_watch_;                                     // of whoever looks at the marks
  std::vector<std::pair<std::size_t, vision::Calibration>> others_;  // other cameras' that have marks
  bool own_ = false;         // the calibration is this camera's: the marks are where it has them
  bool asks_why_ = false;    // marks are missing, and the reasons are to be looked for
  std::vector<int> why_of_;  // the marks for which `why_missing_` holds
  std::string why_missing_;
  std::atomic<double> next_look_{core::Measurement::never};  // at the marks [s]

  mutable std::mutex mutex_;  // of what follows
  std::condition_variable_any asked_;
  std::optional<Question> absence_;
  std::optional<vision::Frame> floor_;  // to be searched for the marks
  std::vector<std::string> alarms_;
  std::vector<UnseenTag> why_lost_;  // by robot
  MarksStatus marks_;
  std::optional<events::CameraMoved> scaled_;  // all tags look larger or smaller at once

  boost::lockfree::spsc_queue<Event, boost::lockfree::capacity<256>> found_;
  std::jthread thread_;
};

}  // namespace skein::app
