#include "app/tools/camera_viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "app/session/experiment_cameras.h"
#include "app/session/picture_copy.h"
#include "app/tools/aside.h"
#include "app/tools/camera_words.h"
#include "core/math/elementary.h"
#include "vision/detector/detector.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/diagnosis/tag_absence.h"
#include "vision/sources/open_source.h"
#include "vision/tags/tag_plane.h"
#include "vision/tracker/tracker.h"

namespace skein::app {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr double rate_over = 2.0;        // [s]
constexpr double between_stills = 0.5;   // [s]
constexpr double between_reasons = 2.0;  // [s]

double now() {
  return Seconds(Clock::now().time_since_epoch()).count();
}

double edge_px_of(const vision::Corners& corners) {
  double sum = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto& from = corners[i];
    const auto& to = corners[(i + 1) % corners.size()];
    sum += core::math::hypot(to[0] - from[0], to[1] - from[1]);
  }
  return sum / static_cast<double>(corners.size());
}

/// How many frames a second come, those included that were passed over while another one was searched.
class FrameRate {
 public:
  /// The frame of this stamp is the `count`th that came.
  void add(double stamp, std::int64_t count) {
    if (!frames_.empty() && stamp <= frames_.back().stamp) frames_.clear();
    frames_.push_back({stamp, count});
    while (stamp - frames_.front().stamp > rate_over) frames_.pop_front();
  }
  double value() const {
    constexpr std::size_t fewest = 3;
    if (frames_.size() < fewest) return none;
    return static_cast<double>(frames_.back().count - frames_.front().count) /
           (frames_.back().stamp - frames_.front().stamp);
  }

 private:
  struct Frame {
    double stamp;
    std::int64_t count;
  };
  std::deque<Frame> frames_;
};

/// Says of each tag of a picture whose it is, how large, and why it is not taken for a robot.
class TagJudge {
 public:
  /// `closed`: nobody waits for reasons any more.
  TagJudge(const Experiment& experiment, std::optional<vision::Calibration> calibration, bool stills,
           std::stop_token closed)
      : wanted_(wanted_tags(experiment)),
        calibration_(std::move(calibration)),
        stills_(stills),
        closed_(std::move(closed)),
        absences_(wanted_.size()) {
    if (calibration_) tracker_.emplace(*calibration_, vision::TrackerOptions{.tags = wanted_});
    for (vision::TagAbsence& absence : absences_) absence.seen(now());
  }

  void detect(const vision::Frame& frame) {
    if (stills_) reasons_.clear();
    found_ = vision::detect_at_both(detector_, frame);
    taken_.clear();
    if (!tracker_) return;
    if (stills_) tracker_.emplace(*calibration_, vision::TrackerOptions{.tags = wanted_});
    for (const vision::TagPose& pose : tracker_->process(frame)) taken_[pose.tag] = pose.corners;
  }

  /// Those of the newest frame, with the reasons that are known by now.
  std::vector<WatchedTag> tags() const {
    std::vector<WatchedTag> tags;
    for (std::size_t robot = 0; robot < wanted_.size(); ++robot) {
      const int tag = wanted_[robot];
      const std::size_t before = tags.size();
      for (const vision::Detection& seen : found_)
        if (seen.tag == tag) tags.push_back(described(tag, seen.corners));
      if (tags.size() == before && taken_.contains(tag)) tags.push_back(described(tag, taken_.at(tag)));
      if (tags.size() == before) tags.push_back({.tag = tag});
      for (std::size_t k = before; k < tags.size(); ++k) {
        tags[k].robot = static_cast<int>(robot);
        judge(tags[k], taken_.contains(tag), tags.size() - before);
      }
    }
    for (const vision::Detection& seen : found_)
      if (std::find(wanted_.begin(), wanted_.end(), seen.tag) == wanted_.end()) {
        tags.push_back(described(seen.tag, seen.corners));
        tags.back().why = "no robot of the experiment has this tag";
      }
    return tags;
  }

  /// Asks why tags are not taken that were not for a while; what is known at once is told before the rest. Of a still
  /// it waits for the answer, some seconds at worst, and calls `more_is_known` for what is known at once.
  void explain(const vision::Frame& frame, const std::function<void()>& more_is_known) {
    if (!tracker_) return;
    const double at = now();
    if (answer_.valid() && answer_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) answer_.get();
    take_news();
    std::vector<vision::MissingTag> missing;
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
      if (taken_.contains(wanted_[i])) {
        absences_[i].seen(at);
        reasons_.erase(wanted_[i]);
        continue;
      }
      if (stills_ || absences_[i].lasts(at)) missing.push_back({wanted_[i], {}});
    }
    if (missing.empty()) return;
    if (stills_) {
      const auto so_far = [&](const std::vector<vision::TagDiagnosis>& tags) {
        reasons_ = sentences_of(tags, *calibration_);
        more_is_known();
      };
      reasons_ = sentences_of(vision::diagnose(frame, *calibration_, missing, so_far, closed_), *calibration_);
      return;
    }
    if (answer_.valid() || at < next_question_) return;
    next_question_ = at + between_reasons;
    answer_ = std::async(std::launch::async, [this, frame, missing] {
      const auto tell = [this](const std::vector<vision::TagDiagnosis>& tags) {
        const std::lock_guard lock(mutex_);
        news_ = sentences_of(tags, *calibration_);
      };
      tell(vision::diagnose(frame, *calibration_, missing, tell, closed_));
    });
  }

 private:
  WatchedTag described(int tag, const vision::Corners& corners) const {
    WatchedTag one{.tag = tag, .seen = true, .corners = corners, .edge_px = edge_px_of(corners)};
    if (!calibration_) return one;
    if (const auto place = vision::place_on_plane(*calibration_, corners)) one.edge = place->edge;
    return one;
  }

  void judge(WatchedTag& tag, bool taken, std::size_t times) const {
    using State = WatchedTag::State;
    tag.state = taken ? State::taken : State::refused;
    if (taken) return;
    const auto reason = reasons_.find(tag.tag);
    if (reason != reasons_.end())
      tag.why = reason->second;
    else if (times > 1)
      tag.why = fmt::format("tag {} is there {} times: give one of the robots another tag", tag.tag, times);
    else if (!tag.seen)
      tag.why = fmt::format("no tag {} is in the picture", tag.tag);
    else if (calibration_)
      tag.why = "the reason is being determined";
    else
      tag.state = State::unjudged;
  }

  static std::map<int, std::string> sentences_of(const std::vector<vision::TagDiagnosis>& tags,
                                                 const vision::Calibration& calibration) {
    std::map<int, std::string> sentences;
    for (const vision::TagDiagnosis& tag : tags) sentences[tag.tag] = vision::sentence(tag, calibration);
    return sentences;
  }

  void take_news() {
    const std::lock_guard lock(mutex_);
    if (news_) reasons_ = *std::exchange(news_, {});
  }

  const std::vector<int> wanted_;
  const std::optional<vision::Calibration> calibration_;
  const bool stills_;
  const std::stop_token closed_;
  vision::TagDetector detector_;
  std::optional<vision::TagTracker> tracker_;
  std::vector<vision::Detection> found_;  // in the newest frame
  std::map<int, vision::Corners> taken_;  // the same, by the tracker
  std::vector<vision::TagAbsence> absences_;
  std::map<int, std::string> reasons_;
  double next_question_ = 0.0;
  std::mutex mutex_;                                // of news_
  std::optional<std::map<int, std::string>> news_;  // what the search has found and nobody has taken yet
  std::future<void> answer_;                        // destroyed first: the search uses what stands above
};

}  // namespace

struct CameraViewer::Work {
  Work(const Experiment& of, const WatchedCamera& watched) : experiment(of), camera(watched) {}

  void run() {
    try {
      load_calibration_of();
      camera.of_run ? watch_run() : watch();
    } catch (const std::exception& error) {
      end(error.what());
    }
    judge.reset();  // on this thread: a question to the diagnosis may still be open
  }

  void load_calibration_of() {
    tl::expected<vision::Calibration, std::string> loaded = tl::unexpected(std::string());
    if (camera.of_run)
      loaded = camera_calibration(experiment);
    else if (!camera.calibration.empty())
      loaded = load_calibration(camera.calibration);
    else
      loaded = tl::unexpected(std::string("without a calibration nothing says where a tag is"));
    if (loaded && experiment.tag_size) loaded->tag_size = *experiment.tag_size;
    const std::lock_guard lock(mutex);
    if (!loaded) {
      newest.note = loaded.error();
      return;
    }
    calibration = *loaded;
    newest.tag_size = calibration->tag_size;
    if (!calibration->world_from_camera)
      newest.note =
          "the calibration has no world frame, so that no tag can be placed on the floor: calibrate the floor";
  }

  /// The judge of frames of this size.
  void begin(const vision::Frame& frame, bool stills) {
    std::optional<vision::Calibration> fits = calibration;
    if (fits && !fits->world_from_camera) fits.reset();
    if (fits && (fits->width != frame.width || fits->height != frame.height)) {
      const std::lock_guard lock(mutex);
      newest.note = fmt::format("the calibration holds for {}x{} px, and the frames are {}x{}", fits->width,
                                fits->height, frame.width, frame.height);
      fits.reset();
    }
    judge.emplace(experiment, std::move(fits), stills, closed.get_token());
  }

  /// One frame; as often as searching takes half of the time.
  void take(const vision::Frame& frame, bool stills) {
    if (!stills && now() < rests_until) return;
    if (!judge) begin(frame, stills);
    const double since = now();
    judge->detect(frame);
    const auto show_tags = [&] { show(frame, judge->tags(), stills); };
    show_tags();
    judge->explain(frame, show_tags);
    if (stills) show_tags();
    rests_until = now() + (now() - since);
  }

  void show(const vision::Frame& frame, std::vector<WatchedTag> tags, bool stills) {
    const std::lock_guard lock(mutex);
    copy_pixels(frame, newest.picture);
    newest.tags = std::move(tags);
    newest.rate = stills ? none : rate.value();
    fresh = true;
  }

  void watch_run() {
    const bool settable = settable_during_run(camera.source);
    if (settable) apply({});
    std::unique_lock lock(mutex);
    newest.camera = camera.source;
    std::int64_t frames = 0;
    vision::Frame frame;
    for (;;) {
      changed.wait(lock, [this] { return leaves() || handed || !wanted.empty(); });
      if (leaves()) return;
      const vision::ControlSettings set = std::exchange(wanted, {});
      const std::optional<Picture> picture = std::exchange(handed, {});
      lock.unlock();
      if (!set.empty() && settable) apply(set);
      if (picture) {
        copy_pixels(*picture, frame);
        frame.captured_at = now();
        frame.index = frames++;
        take(frame, false);
      }
      lock.lock();
    }
  }

  tl::expected<std::unique_ptr<vision::FrameSource>, std::string> open(bool live) {
    vision::SourceOptions options;
    options.keep_waiting = [this] { return !leaves(); };
    if (live) {
      if (calibration) {
        options.width = calibration->width;
        options.height = calibration->height;
      }
      options.rate = experiment.rate;
      options.trigger = camera.trigger;
      options.controls = controls;
    }
    auto source = vision::open_source(camera.source, options);
    const std::lock_guard lock(mutex);
    if (!source) return source;
    newest.camera = (*source)->describe();
    return source;
  }

  void watch() {
    if (const std::string wrong = wrong_source(camera.source); !wrong.empty()) return end(wrong);
    const bool live = vision::is_camera(camera.source);
    const bool set_beside = settable_during_run(camera.source);
    if (live) {
      controls = camera.settings;
      if (const std::string problem = apply(controls); !problem.empty()) return end(problem);
    }
    auto source = open(live);
    if (!source) return end(source.error());
    const bool stills = (*source)->stills();
    std::int64_t read = 0, outages = 0;
    std::optional<double> last;
    vision::Frame frame;
    while (!leaves()) {
      const vision::ControlSettings set = take_wanted();
      if (live && !set.empty()) {
        if (!set_beside) source->reset();  // who reads it is in the way
        for (const auto& one : set) {
          if (!apply({one}).empty()) continue;
          std::erase_if(controls, [&](const auto& other) { return other.first == one.first; });
          controls.push_back(one);
        }
        if (!set_beside) source = open(live);
        if (!source) return end(source.error());
      }
      const auto more = (*source)->read(frame);
      if (!more) return end(more.error());
      if (!*more) break;
      if (!live && last && !rest(stills ? between_stills : frame.captured_at - *last)) break;
      last = frame.captured_at;
      const vision::SourceStatus status = (*source)->status();
      {
        const std::lock_guard lock(mutex);
        rate.add(frame.captured_at, ++read + status.passed_over);
        if (!live) newest.notices = status.remarks;
      }
      take(frame, stills);
      const std::int64_t before = std::exchange(outages, status.outages);
      if (set_beside && outages > before) apply(controls);  // it came back as it was opened at first
    }
    const std::span<const std::string> skipped = (*source)->skipped();
    end(last || skipped.empty() ? std::string() : skipped.front());
  }

  /// Sets them and reads back; empty, or why that is impossible.
  std::string apply(const vision::ControlSettings& set) {
    auto settings = vision::camera_settings(camera.source, set);
    std::string problem = settings ? std::string() : settings.error();
    if (!settings && !set.empty()) settings = vision::camera_settings(camera.source);
    const std::lock_guard lock(mutex);
    newest.notices = problem.empty() ? std::vector<std::string>() : std::vector{problem};
    if (settings) {
      newest.notices.insert(newest.notices.end(), settings->notices.begin(), settings->notices.end());
      newest.settings = settings->all;
    }
    fresh = true;
    return problem;
  }

  vision::ControlSettings take_wanted() {
    const std::lock_guard lock(mutex);
    return std::exchange(wanted, {});
  }

  bool leaves() const { return closed.stop_requested(); }

  /// false: the viewer has been closed.
  bool rest(double seconds) {
    std::unique_lock lock(mutex);
    return !changed.wait_for(lock, Seconds(std::clamp(seconds, 0.0, 1.0)), [this] { return leaves(); });
  }

  void end(const std::string& reason) {
    const std::lock_guard lock(mutex);
    newest.problem = reason;
    newest.over = true;
    fresh = true;
  }

  const Experiment experiment;
  const WatchedCamera camera;
  std::stop_source closed;  // stopped under the mutex; then `changed` is notified
  // The thread's:
  std::optional<vision::Calibration> calibration;
  std::optional<TagJudge> judge;
  vision::ControlSettings controls;
  double rests_until = 0.0;
  mutable std::mutex mutex;  // of all that follows
  std::condition_variable changed;
  bool fresh = false;
  vision::ControlSettings wanted;
  std::optional<Picture> handed;
  CameraView newest;
  FrameRate rate;
  std::int64_t handed_over = 0;
};

CameraViewer::CameraViewer(const Experiment& experiment, const WatchedCamera& camera)
    : work_(std::make_shared<Work>(experiment, camera)) {
  run_aside([work = work_] { work->run(); });
}

CameraViewer::~CameraViewer() {
  const std::lock_guard lock(work_->mutex);
  work_->closed.request_stop();
  work_->changed.notify_all();
}

void CameraViewer::hand(const Picture& picture) {
  const std::lock_guard lock(work_->mutex);
  work_->handed = picture;
  work_->rate.add(now(), ++work_->handed_over);
  work_->changed.notify_all();
}

void CameraViewer::set(const std::string& name, double value) {
  const std::lock_guard lock(work_->mutex);
  work_->wanted.emplace_back(name, value);
  work_->changed.notify_all();
}

bool CameraViewer::view(CameraView& out) {
  const std::lock_guard lock(work_->mutex);
  if (!work_->fresh) return false;
  work_->fresh = false;
  out = work_->newest;
  return true;
}

bool settable_during_run(const std::string& source) {
  return vision::settable_while_read(source);
}

}  // namespace skein::app
