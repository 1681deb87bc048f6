#include "vision/track/track_tracker.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include "vision/detector/detector.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/diagnosis/tag_absence.h"
#include "vision/frames/frame.h"
#include "vision/recording/picture_file.h"
#include "vision/sources/open_source.h"
#include "vision/track/track_parts.h"
#include "vision/tracker/tracker.h"

namespace skein::vision {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<int> ids_of(const std::vector<Detection>& found) {
  std::vector<int> ids;
  for (const Detection& detection : found) detail::insert(ids, detection.tag);
  return ids;
}

/// Asks why tags have no pose, and says it once for each tag and reason.
class Explainer {
 public:
  Explainer(const TrackTrackerOptions& options, bool apart) : options_(options), apart_(apart) {}

  bool busy() {
    if (answer_.valid() && answer_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) tell(answer_.get());
    return answer_.valid();
  }

  /// Not while it is busy. `picture`: a picture's name, which stands before the sentences; of a stream empty.
  void ask(const Frame& frame, const std::vector<MissingTag>& missing, std::string picture) {
    name_ = std::move(picture);
    if (!apart_) {
      tell(answer(frame, *options_.track.calibration, missing));
      return;
    }
    answer_ = std::async(std::launch::async, [frame, missing, calibration = *options_.track.calibration] {
      constexpr int niceness = 5;  // of this thread: behind the tracker, but the end of the command waits for it
      ::setpriority(PRIO_PROCESS, 0, niceness);
      return answer(frame, calibration, missing);
    });
  }

  void wait() {
    if (answer_.valid()) tell(answer_.get());
  }

  /// Of pictures: which are too soft, which is not said of each.
  void tell_of_soft() {
    for (const std::string& sentence : soft_sentences(soft_)) say(sentence);
    soft_.clear();
  }

  /// Why all tags look so has been said.
  bool of_all() const { return of_all_; }
  /// Why this tag has no pose has been said.
  bool has_told_of(int tag) const {
    return std::any_of(told_.begin(), told_.end(), [&](const auto& told) { return told.second.first == tag; });
  }

 private:
  struct Answer {
    TagDiagnosis tag;
    Frame picture;
  };

  static std::vector<Answer> answer(const Frame& frame, const Calibration& calibration,
                                    const std::vector<MissingTag>& missing) {
    std::vector<Answer> answers;
    for (const TagDiagnosis& tag : diagnose(frame, calibration, missing))
      answers.push_back({tag, picture_of(frame, tag)});
    for (Answer& one : answers) one.picture.source = frame.source;
    return answers;
  }

  /// " (picture: crops/tag-3.png)", of pictures that are searched one by one " (picture: crops/0007.png-tag-3.png)".
  std::string picture_of_tag(const Answer& one) const {
    if (options_.crops.empty() || one.picture.width == 0) return {};
    const std::string of = name_.empty() ? "" : one.picture.source + "-";
    const std::string path = fmt::format("{}/{}tag-{}.png", options_.crops, of, one.tag.tag);
    const auto written = write_png(one.picture, path);
    return fmt::format(" (picture: {})", written ? path : written.error());
  }

  void say(const std::string& sentence) const {
    if (options_.tell) options_.tell(sentence);
  }

  void tell(const std::vector<Answer>& answers) {
    SoftPicture soft{.name = name_};
    for (const Answer& one : answers) {
      const TagDiagnosis& tag = one.tag;
      of_all_ = of_all_ || tag.why == NotSeen::other_family || tag.why == NotSeen::mirrored;
      // Of many pictures, each shows some of the tags.
      if (!name_.empty() && tag.why == NotSeen::not_found) continue;
      if (!told_.insert({name_, {tag.tag, tag.why}}).second) continue;
      const std::string crop = picture_of_tag(one);
      if (tag.why == NotSeen::blurred && crop.empty())
        soft.tags.push_back(tag);
      else
        say((name_.empty() ? "" : name_ + ": ") + sentence(tag, *options_.track.calibration) + crop);
    }
    soft_.push_back(std::move(soft));
    if (name_.empty()) tell_of_soft();
  }

  const TrackTrackerOptions& options_;
  bool apart_;  // on a thread of its own
  std::string name_;
  std::vector<SoftPicture> soft_;  // that were not told of
  std::future<std::vector<Answer>> answer_;
  std::set<std::pair<std::string, std::pair<int, NotSeen>>> told_;
  bool of_all_ = false;
};

/// The work of one call.
class Body {
 public:
  Body(const TrackTrackerOptions& options, bool live)
      : options_(options),
        calibration_(*options.track.calibration),
        table_(options.track.csv, options.track.calibration),
        explainer_(options, live) {}

  double now() const { return options_.clock ? options_.clock() : nan; }
  bool well() const { return table_.well(); }

  /// A frame of a stream.
  void follow(const Frame& frame, FrameLatency& latency) {
    if (!tracker_) {
      std::vector<int> tags = options_.tags;
      if (tags.empty()) tags = ids_of(detect(frame));
      if (tags.empty()) return;
      begin(tags, frame.captured_at);
    }
    const double since = now();
    const std::vector<TagPose>& poses = tracker_->process(frame);
    latency.tracker = now() - since;
    latency.stages = tracker_->stage_times();
    for (const TagPose& pose : poses) take(frame, pose);
    for (Followed& tag : followed_) {
      const auto pose =
          std::find_if(poses.begin(), poses.end(), [&](const TagPose& one) { return one.tag == tag.tag; });
      const bool seen = pose != poses.end();
      summary_.lost += tag.seen && !seen ? 1 : 0;
      tag.seen = seen;
      if (seen) {
        tag.absence.seen(frame.captured_at);
        tag.last = pose->pose;
      }
    }
    explain(frame, [&](const Followed& tag) { return tag.absence.due(frame.captured_at); });
  }

  /// A picture by itself.
  void search(const Frame& frame, FrameLatency& latency) {
    const std::vector<int> read = ids_of(detect_at_both(detector_, frame));
    const std::vector<int> tags = options_.tags.empty() ? read : options_.tags;
    for (const int tag : tags) detail::insert(summary_.followed, tag);
    if (tags.empty()) return;
    TagTracker tracker(calibration_, {.tags = tags, .clock = options_.clock});
    const double since = now();
    std::vector<TagPose> poses = tracker.process(frame);
    latency.tracker = now() - since;
    latency.stages = tracker.stage_times();
    summary_.counters += tracker.counters();
    const auto has = [&](int tag) {
      return std::any_of(poses.begin(), poses.end(), [&](const TagPose& pose) { return pose.tag == tag; });
    };
    const auto lacks = [&](int tag) { return std::find(tags.begin(), tags.end(), tag) != tags.end() && !has(tag); };
    if (std::any_of(read.begin(), read.end(), lacks)) {
      const double other = decimate_for_edge(tag_edge_px(calibration_)) > 1.5 ? 1.0 : 2.0;
      TagTracker again(calibration_, {.tags = tags, .decimate = other});
      for (const TagPose& pose : again.process(frame))
        if (!has(pose.tag)) poses.push_back(pose);
      summary_.counters += again.counters();
    }
    for (const TagPose& pose : poses) take(frame, pose);
    summary_.counters.poses = summary_.track.detections;
    summary_.counters.frames = summary_.track.frames + 1;
    std::vector<MissingTag> missing;
    for (const int tag : tags)
      if (!has(tag)) missing.push_back({tag, {}});
    if (!missing.empty()) explainer_.ask(frame, missing, frame.source);
  }

  /// What is known of tags and was not told yet; also before an error that ends the call.
  void tell_the_rest() {
    explainer_.wait();
    explainer_.tell_of_soft();
  }

  TrackTrackerSummary conclude(const Frame& last, bool stills) {
    tell_the_rest();
    if (tracker_) {
      explain(last, [](const Followed& tag) { return !tag.absence.asked() && !tag.seen; });
      explainer_.wait();
      summary_.counters = tracker_->counters();
      if (options_.tags.empty() && options_.tell)
        for (const int tag : ids_of(detect(last)))
          if (!std::binary_search(summary_.followed.begin(), summary_.followed.end(), tag))
            options_.tell(fmt::format("tag {} came later and was not followed: name it with --tags", tag));
    }
    if (stills && !options_.tags.empty() && options_.tell)
      for (const int tag : summary_.followed)
        if (!std::binary_search(summary_.track.ids.begin(), summary_.track.ids.end(), tag) &&
            !explainer_.has_told_of(tag))
          options_.tell(summary_.track.frames == 1 ? sentence({.tag = tag}, calibration_)
                                                   : fmt::format("tag {} is in none of the pictures", tag));
    const bool none = summary_.track.frames > 0 && summary_.track.detections == 0;
    if (none && !explainer_.of_all() && (!stills || options_.tags.empty()))
      summary_.track.why_no_tag = why_no_tag(last);
    return std::move(summary_);
  }

  bool finish() { return table_.finish(); }
  TrackTrackerSummary& summary() { return summary_; }

 private:
  struct Followed {
    int tag = 0;
    TagAbsence absence{};
    std::optional<core::Pose> last{};  // none: it was never seen
    bool seen = false;                 // in the last frame
  };

  const std::vector<Detection>& detect(const Frame& frame) {
    detector_.set_decimate(1.0);
    return detector_.detect(frame);
  }

  void begin(const std::vector<int>& tags, double at) {
    tracker_.emplace(calibration_, TrackerOptions{.tags = tags, .clock = options_.clock});
    for (const int tag : tags) {
      detail::insert(summary_.followed, tag);
      followed_.push_back({.tag = tag});
      followed_.back().absence.seen(at);
    }
  }

  void take(const Frame& frame, const TagPose& pose) {
    table_.add(frame, pose);
    ++summary_.track.detections;
    detail::insert(summary_.track.ids, pose.tag);
    switch (pose.how) {
      case How::none:
      case How::detected:
        ++summary_.detected;
        break;
      case How::tracked:
        ++summary_.tracked;
        break;
      case How::recovered:
        ++summary_.recovered;
        break;
    }
  }

  template <typename Wanted>
  void explain(const Frame& frame, const Wanted& wanted) {
    if (explainer_.busy() || std::none_of(followed_.begin(), followed_.end(), wanted)) return;
    std::vector<MissingTag> missing;
    for (Followed& tag : followed_)
      if (wanted(tag)) {
        missing.push_back({tag.tag, tag.last});
        tag.absence.ask();
      }
    explainer_.ask(frame, missing, {});
  }

  const TrackTrackerOptions& options_;
  const Calibration& calibration_;
  detail::Table table_;
  Explainer explainer_;
  TagDetector detector_;
  std::optional<TagTracker> tracker_;
  std::vector<Followed> followed_;
  TrackTrackerSummary summary_;
};

}  // namespace

tl::expected<TrackTrackerSummary, std::string> track_with_tracker(const TrackTrackerOptions& options) {
  const TrackOptions& track = options.track;
  if (!track.calibration || !track.calibration->world_from_camera)
    return tl::unexpected(
        std::string("the tracker needs a calibration with a world frame (skein calibrate floor): it places tags on the "
                    "floor"));
  SourceOptions wanted = track.camera;
  if (track.keep_going) wanted.keep_waiting = [&] { return track.keep_going(-1); };
  wanted.width = track.calibration->width;
  wanted.height = track.calibration->height;
  auto source = open_source(track.source, wanted);
  if (!source) return tl::unexpected(source.error());
  auto recorder = detail::open_recorder(track.record, track.notes, track.source);
  if (!recorder) return tl::unexpected(recorder.error());
  const bool live = is_camera(track.source);
  const bool stills = (*source)->stills();

  Body body(options, live);
  TrackSummary& summary = body.summary().track;
  summary.source = (*source)->describe();
  const auto failed = [&](std::string why) {
    body.tell_the_rest();
    return tl::unexpected(std::move(why));
  };
  Frame frame;
  while (track.max_frames == 0 || summary.frames < track.max_frames) {
    const double since = body.now();
    const auto more = (*source)->read(frame);
    if (!more) return failed(more.error());
    if (!*more) break;
    if (const std::string wrong = detail::wrong_size(frame, summary.source, track.calibration); !wrong.empty())
      return failed(wrong);
    const bool stamped = live && frame.arrived_at > 0.0;
    FrameLatency latency{.arrival = stamped ? frame.arrived_at - frame.captured_at : nan,
                         .grey = stamped ? body.now() - frame.arrived_at
                                 : live  ? nan
                                         : body.now() - since,
                         .tracker = nan};
    if (stills)
      body.search(frame, latency);
    else
      body.follow(frame, latency);
    if (options.latency) options.latency(latency);
    if (*recorder && live) (*recorder)->offer(frame);
    if (*recorder && !live) (*recorder)->add(frame);
    ++summary.frames;
    if (!body.well()) return failed("the CSV cannot be written");
    if (track.keep_going && !track.keep_going(summary.frames)) break;
  }
  if (*recorder) summary.recording = (*recorder)->finish();
  if (!body.finish()) return failed("the CSV cannot be written");
  summary.status = (*source)->status();
  summary.skipped.assign((*source)->skipped().begin(), (*source)->skipped().end());
  if (const std::string problem = detail::nothing_read(**source, summary.frames); !problem.empty())
    return failed(problem);
  return body.conclude(frame, stills);
}

}  // namespace skein::vision
