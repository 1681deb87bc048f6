#include "app/session/camera_findings.h"

#include <fmt/format.h>

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "app/session/experiment_cameras.h"
#include "app/session/picture_copy.h"
#include "vision/tags/tag_plane.h"

namespace skein::app {

std::string size_fault(const vision::Frame& frame, const vision::Calibration& calibration) {
  if (frame.width == calibration.width && frame.height == calibration.height) return {};
  return fmt::format("the camera's frames are {}x{} px, but the calibration holds for {}x{}", frame.width, frame.height,
                     calibration.width, calibration.height);
}

CameraFindings::CameraFindings(const Experiment& experiment, std::size_t number, const vision::Calibration& calibration,
                               std::span<const int> wanted, const vision::TagTracker& tracker, const LastSights& sights,
                               bool wall_clock)
    : experiment_(experiment),
      number_(number),
      prefix_(camera_prefix(experiment, number)),
      calibration_(calibration),
      wanted_(wanted),
      tracker_(tracker),
      sights_(sights),
      wall_clock_(wall_clock),
      absences_(experiment.robots.size()),
      expected_(experiment.cameras() > 1 ? experiment.robots.size() : 0),
      scale_watch_(calibration),
      mark_watch_(calibration, wanted_tags(experiment)),
      why_lost_(experiment.robots.size()) {
  marks_.watched = mark_watch_.marks() >= vision::MarkWatch::least_seen;
  for (std::size_t k = 0; k < experiment.cameras(); ++k) {
    const auto of_other = k == number ? tl::unexpected(std::string()) : camera_calibration(experiment, k);
    if (of_other && vision::MarkWatch(*of_other, wanted_tags(experiment)).marks() >= vision::MarkWatch::least_seen)
      others_.emplace_back(k, *of_other);
  }
  looks_for_marks_ = marks_.watched || !others_.empty();
  marks_.known = !marks_.watched;
}

void CameraFindings::start() {
  thread_ = std::jthread([this](const std::stop_token& stop) { thread(stop); });
}

void CameraFindings::end() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

void CameraFindings::thread(const std::stop_token& stop) {
  constexpr int niceness = 5;  // behind camera and tick, but end() waits for it on a busy machine too
  ::setpriority(PRIO_PROCESS, 0, niceness);
  std::unique_lock lock(mutex_);
  // The question stays where it is while it is worked on: so there is one at a time.
  const auto work_on = [&](auto& question, const char* what, auto&& answer) {
    if (!question) return;
    lock.unlock();
    try {
      answer(*question);
    } catch (const std::exception& error) {
      tell(fmt::format("{} cannot be determined: {}", what, error.what()));
    }
    lock.lock();
    question.reset();
  };
  while (asked_.wait(lock, stop, [this] { return absence_ || floor_; })) {
    work_on(absence_, "the reason why a tag is not seen", [&](const Question& question) { explain(question, stop); });
    work_on(floor_, "whether the camera has moved", [this](const vision::Frame& frame) { look_at_marks(frame, true); });
  }
}

void CameraFindings::tell(std::string sentence) {
  const std::lock_guard lock(mutex_);
  alarms_.push_back(std::move(sentence));
}

void CameraFindings::tell_once(std::span<const std::string> sentences) {
  for (const std::string& sentence : sentences)
    if (!sentence.empty() && told_once_.insert(sentence).second) tell(prefix_ + sentence);
}

std::vector<std::string> CameraFindings::alarms() {
  const std::lock_guard lock(mutex_);
  return std::exchange(alarms_, {});
}

std::size_t CameraFindings::robot_of(int tag) const {
  return static_cast<std::size_t>(std::find(wanted_.begin(), wanted_.end(), tag) - wanted_.begin());
}

vision::MissingTag CameraFindings::missing_tag(std::size_t robot, const core::Measurement& newest) const {
  return {.tag = wanted_[robot],
          .last = newest.ever_seen() ? std::optional(newest.pose) : std::nullopt,
          .lifted_from = tracker_.lifted_from(wanted_[robot]),
          .blur = focus_watch_.out_of_focus()};
}

UnseenTag CameraFindings::unseen_tag(const vision::Frame& frame, const vision::TagDiagnosis& tag) const {
  UnseenTag unseen{tag.tag, tag.why, vision::sentence(tag, calibration_)};
  if (tag.why == core::NotSeen::at_border && experiment_.cameras() > 1)
    unseen.sentence = fmt::format("the border of this picture cuts tag {}, and no other camera sees it", tag.tag);
  if (tag.size > 0.0) unseen.size = tag.size;
  const vision::Frame crop = vision::picture_of(frame, tag);
  if (crop.width == 0) return unseen;
  auto picture = std::make_shared<Picture>();
  copy_pixels(crop, *picture);
  unseen.picture = std::move(picture);
  if (crops_)
    unseen.file = crops_->add({robot_of(tag.tag), crop_file(tag.tag, number_, experiment_.cameras()),
                               prefix_ + unseen.sentence, unseen.picture});
  return unseen;
}

std::vector<UnseenTag> CameraFindings::why_not_seen(const vision::Frame& frame,
                                                    std::span<const vision::MissingTag> missing) const {
  if (std::string fault = size_fault(frame, calibration_); !fault.empty()) return {{.sentence = std::move(fault)}};
  std::vector<UnseenTag> unseen;
  for (const vision::TagDiagnosis& tag : vision::diagnose(frame, calibration_, missing))
    unseen.push_back(unseen_tag(frame, tag));
  return unseen;
}

/// For each robot that was seen and has not been seen for half a second, the reason is requested once, from the camera
/// that saw it last. One frame serves for all of them.
void CameraFindings::watch_absences(const vision::Frame& frame, std::span<const core::Measurement> tags,
                                    std::span<const vision::SeenElsewhere> elsewhere) {
  constexpr double between = 2.0, between_searches = 5.0;  // [s]
  const double now = frame.captured_at;
  missing_.clear();
  // A robot that was never seen is looked for again and again, since the operator may correct tags, light and camera
  // meanwhile.
  const bool search = !(now < next_search_);
  if (search) next_search_ = now + between_searches;
  for (std::size_t i = 0; i < absences_.size(); ++i) {
    const core::Measurement& tag = tags[i];
    if (tag.captured_at >= now || (!tag.ever_seen() && search)) absences_[i].seen(now);
    if (absences_[i].due(now) && sights_.newest(i) <= tag.captured_at) missing_.push_back(missing_tag(i, tag));
  }
  expect_here(frame, tags, elsewhere);
  if (missing_.empty() || now < next_absence_) return;
  if (wall_clock_) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock || absence_) return;
    absence_.emplace(Question{frame, missing_, seen_elsewhere_});
    asked_.notify_all();
    next_absence_ = now + between;
  }
  for (std::size_t i = 0; i < absences_.size(); ++i)
    for (const vision::MissingTag& tag : missing_)
      if (wanted_[i] == tag.tag) (seen_elsewhere_.count(tag.tag) > 0 ? expected_[i].absence : absences_[i]).ask();
  if (!wall_clock_) explain({frame, missing_, seen_elsewhere_});
}

/// Robots that another camera sees, or has seen last, where this one should see them too: without this nobody would
/// know of a camera that is blind until a robot drives under it alone.
void CameraFindings::expect_here(const vision::Frame& frame, std::span<const core::Measurement> tags,
                                 std::span<const vision::SeenElsewhere> elsewhere) {
  const double now = frame.captured_at;
  seen_elsewhere_.clear();
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    auto& [pose, absence] = expected_[i];
    const auto by_other = std::find_if(elsewhere.begin(), elsewhere.end(),
                                       [&](const vision::SeenElsewhere& seen) { return seen.tag == wanted_[i]; });
    const bool here = tags[i].captured_at >= now;
    if (!here && by_other != elsewhere.end())
      pose = shows_tag(calibration_, by_other->pose.x, by_other->pose.y) ? std::optional(by_other->pose) : std::nullopt;
    else if (here || !absence.lasts(now))
      pose.reset();  // what hides it, if it is not seen, hides it from all
    if (!pose) {
      absence.seen(now);
      continue;
    }
    const auto asked = [&](const vision::MissingTag& one) { return one.tag == wanted_[i]; };
    if (!absence.due(now) || std::any_of(missing_.begin(), missing_.end(), asked)) continue;
    missing_.push_back(missing_tag(i, tags[i]));
    missing_.back().last = pose;
    seen_elsewhere_.insert(wanted_[i]);
  }
}

void CameraFindings::explain(const Question& question, const std::stop_token& stop) {
  if (!size_fault(question.frame, calibration_).empty()) return;
  std::vector<vision::TagDiagnosis> told;
  const auto tell_news = [&](const std::vector<vision::TagDiagnosis>& tags) {
    std::vector<UnseenTag> news;
    for (std::size_t i = 0; i < tags.size(); ++i)
      if (told.empty() || tags[i].why != told[i].why) news.push_back(unseen_tag(question.frame, tags[i]));
    told = tags;
    tell_why(question, news);
  };
  tell_news(vision::diagnose(question.frame, calibration_, question.missing, tell_news, stop));
}

void CameraFindings::tell_why(const Question& question, const std::vector<UnseenTag>& unseen) {
  const std::lock_guard lock(mutex_);
  for (const UnseenTag& tag : unseen) {
    const std::size_t robot = robot_of(tag.tag);
    why_lost_[robot] = tag;
    if (question.seen_elsewhere.count(tag.tag) > 0) {
      tell_of_seen_elsewhere(tag);
      continue;
    }
    const bool ever = std::any_of(question.missing.begin(), question.missing.end(),
                                  [&](const vision::MissingTag& one) { return one.tag == tag.tag && one.last; });
    if (!ever) continue;  // it is no news that it is not there
    found_.push(events::NotSeen{robot, tag.why});
    alarms_.push_back(fmt::format("{}robot {} is lost: {}", prefix_, robot + 1, tag.text()));
  }
}

/// Under the mutex.
void CameraFindings::tell_of_seen_elsewhere(const UnseenTag& tag) {
  if (tag.why == core::NotSeen::at_border) return;
  std::string sentence = fmt::format("{}robot {} is not seen, though another camera sees it where this one looks: {}",
                                     prefix_, robot_of(tag.tag) + 1, tag.text());
  if (tag.why == core::NotSeen::not_found)
    sentence +=
        "; if nothing hides it, one of the calibrations is another camera's, or its floor has another origin or axes";
  alarms_.push_back(std::move(sentence));
}

std::vector<UnseenTag> CameraFindings::why_lost() const {
  const std::lock_guard lock(mutex_);
  return why_lost_;
}

events::CameraMoved CameraFindings::moved() const {
  return {.camera = experiment_.cameras() == 1 ? events::only_camera : number_};
}

/// Now and then, and soon again where a sight is to be confirmed.
void CameraFindings::watch_marks(const vision::Frame& frame) {
  if (!looks_for_marks_ || !size_fault(frame, calibration_).empty() ||
      frame.captured_at < next_look_.load(std::memory_order_acquire))
    return;
  // The first ones, on which a start waits, are not left to a thread that a busy machine lets wait: robots still stand.
  constexpr int most_own_looks = 4;
  const bool own_look = !wall_clock_ || (marks().sentence.empty() && own_looks_ < most_own_looks);
  if (own_look) {
    ++own_looks_;
    looks_for_marks_ = marks_.watched || own_looks_ < most_own_looks;
    return look_at_marks(frame, !wall_clock_);
  }
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock || floor_) return;
  floor_.emplace(frame);
  asked_.notify_all();
}

void CameraFindings::look_at_marks(const vision::Frame& frame, bool may_search) {
  constexpr double between = 2.0;  // [s]
  next_look_.store(frame.captured_at + between, std::memory_order_release);
  if (marks_.watched) look_at_own_marks(frame, may_search);
  const auto known = mark_watch_.known();
  own_ = own_ || (known && (known->state == vision::MarkSight::State::in_place ||
                            known->state == vision::MarkSight::State::some_moved));
  const std::optional<std::size_t> whose = own_ ? std::nullopt : whose_marks(frame);
  const std::lock_guard lock(mutex_);
  if (whose && marks_.exchanged.empty())
    marks_.exchanged =
        fmt::format("{}the marks on the floor show that {}, which camera {} has, is this camera's calibration", prefix_,
                    experiment_.camera_at(*whose).calibration, *whose + 1);
}

/// The camera in whose calibration they are where this picture shows them.
std::optional<std::size_t> CameraFindings::whose_marks(const vision::Frame& frame) const {
  for (const auto& [number, calibration] : others_) {
    if (!size_fault(frame, calibration).empty()) continue;
    vision::MarkWatch watch(calibration, std::span(wanted_).first(experiment_.robots.size()));
    watch.update(frame);
    if (watch.known() && watch.known()->state == vision::MarkSight::State::in_place) return number;
  }
  return {};
}

/// What is known of the marks that are missing, to be added to a sentence: "; mark 20 is not seen: ...". That search
/// takes up to some seconds.
std::string CameraFindings::why_marks_are_missing(const vision::Frame& frame, bool may_search) {
  const std::vector<vision::MissingTag> missing = mark_watch_.missing();
  std::vector<int> ids;
  ids.reserve(missing.size());
  for (const vision::MissingTag& mark : missing) ids.push_back(mark.tag);
  if (asks_why_ && may_search) {
    asks_why_ = false;
    why_of_ = ids;
    why_missing_.clear();
    if (!missing.empty())
      for (const std::string& why : mark_sentences(vision::diagnose(frame, calibration_, missing), calibration_))
        why_missing_ += "; " + why;
  }
  return ids == why_of_ ? why_missing_ : std::string();
}

void CameraFindings::look_at_own_marks(const vision::Frame& frame, bool may_search) {
  constexpr double in_doubt = 0.5;  // [s]
  const bool was_blind = mark_watch_.blind() != nullptr;
  const bool news = mark_watch_.update(frame);
  const bool owes_reasons = asks_why_;  // of what was told without them
  const bool becomes_blind = mark_watch_.blind() != nullptr && !was_blind;
  // Of a camera that has moved nobody knows where it should see them.
  if (news) asks_why_ = mark_watch_.known()->state != vision::MarkSight::State::camera_moved;
  asks_why_ = asks_why_ || becomes_blind;
  const std::string reasons = why_marks_are_missing(frame, may_search);
  if (mark_watch_.doubts() || asks_why_) next_look_.store(frame.captured_at + in_doubt, std::memory_order_release);
  const std::optional<vision::MarkSight>& sight = mark_watch_.known();
  if (!sight) return;
  const vision::MarkSight* blind = mark_watch_.blind();
  const std::string sentence = vision::sentence(blind ? *blind : *sight) + reasons;
  const bool has_moved = sight->state == vision::MarkSight::State::camera_moved;
  events::CameraMoved event = moved();
  event.by = sight->by;
  event.turn = sight->turn;
  event.marks = sight->moved.size();
  const bool well = sight->state == vision::MarkSight::State::in_place;
  const bool goes_on = experiment_.failure.camera_moved == FailureSpec::CameraMoved::go_on;
  const std::lock_guard lock(mutex_);
  marks_.known = vision::tells(sight->state);
  marks_.moved = has_moved ? std::optional(event) : std::nullopt;
  marks_.sentence = prefix_ + sentence;
  // The part that stops the robots reports that they are stopped.
  const bool is_told = news && !well && (!has_moved || goes_on);
  const bool has_reasons_now = owes_reasons && !reasons.empty() && !vision::tells(sight->state);
  if (is_told || has_reasons_now) alarms_.push_back(prefix_ + sentence);
  if (becomes_blind)
    alarms_.push_back(fmt::format("{}{}; it has been so for {:g} s: clear the marks, or calibrate the floor anew{}",
                                  prefix_, vision::sentence(*blind), vision::MarkWatch::patience, reasons));
  if (news && has_moved) found_.push(event);
}

MarksStatus CameraFindings::marks() const {
  const std::lock_guard lock(mutex_);
  MarksStatus status = marks_;
  if (!status.moved) status.moved = scaled_;
  return status;
}

/// Whether they are as large and as sharp as they should be, and stay so.
void CameraFindings::watch_tags(double captured_at) {
  const std::array sentences = {scale_watch_.update(captured_at, tracker_.stretch()),
                                scale_watch_.update_change(captured_at, tracker_.scale_change()),
                                focus_watch_.update(captured_at, tracker_.blur())};
  const auto& scale = scale_watch_.moved();
  const std::lock_guard lock(mutex_);
  for (const std::string& sentence : sentences)
    if (!sentence.empty()) alarms_.push_back(prefix_ + sentence);
  if (scale.has_value() == scaled_.has_value()) return;
  scaled_.reset();
  if (!scale) return;
  scaled_ = moved();
  scaled_->tags = scale->tags;
  scaled_->scale = scale->by;
  found_.push(*scaled_);
}

}  // namespace skein::app
