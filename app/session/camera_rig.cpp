#include "app/session/camera_rig.h"

#include <fmt/format.h>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "app/experiment/control_settings.h"
#include "app/run/timing.h"
#include "app/session/camera_film.h"
#include "vision/sources/open_source.h"
#include "vision/tags/tag_family.h"

namespace skein::app {

namespace {

constexpr double mark_moved_by = 0.05;  // for practice [m]

/// `part`: of the picture's height.
std::string frozen_reason(double part) {
  if (part == 1.0) return "it delivers the same picture again and again";
  return fmt::format("{:.0f} % of its picture show what older ones showed", 100.0 * part);
}

bool ever_seen(const core::Measurement& tag) {
  return tag.captured_at > core::Measurement{}.captured_at;
}

/// The part of the arena that a synthetic camera sees: as many columns and rows as there are cameras, the longer side
/// of the arena divided into more.
vision::Calibration shared_floor(const Experiment& experiment, std::size_t number) {
  constexpr double overlap = 0.1;  // over each border of its part, and the margin of overhead_calibration [m]
  const std::size_t n = experiment.cameras();
  if (n == 1) return vision::overhead_calibration(experiment.arena_width, experiment.arena_height);
  std::size_t fewer = 1;
  for (std::size_t k = 1; k * k <= n; ++k)
    if (n % k == 0) fewer = k;
  const bool wide = experiment.arena_width >= experiment.arena_height;
  const std::size_t columns = std::max<std::size_t>(1, wide ? n / fewer : fewer), rows = n / columns;
  const std::size_t column = number % columns, row = number / columns;
  const double width = experiment.arena_width / static_cast<double>(columns);
  const double height = experiment.arena_height / static_cast<double>(rows);
  const Eigen::Vector2d centre((static_cast<double>(column) + 0.5) * width - 0.5 * experiment.arena_width,
                               0.5 * experiment.arena_height - (static_cast<double>(row) + 0.5) * height);
  const double along = width + (columns > 1 ? 2.0 * overlap : 0.0);
  const double across = height + (rows > 1 ? 2.0 * overlap : 0.0);
  if (along >= across) return vision::overhead_calibration(along, across, centre);
  // A picture is wider than high: over a part that is not, the camera hangs turned by a right angle.
  vision::Calibration camera = vision::overhead_calibration(across, along, {centre.y(), -centre.x()});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  camera.world_from_camera->rotation = turn * camera.world_from_camera->rotation;
  camera.world_from_camera->position = turn * camera.world_from_camera->position;
  return camera;
}

}  // namespace

namespace {

tl::expected<vision::Calibration, std::string> calibration_as_filed(const Experiment& experiment, std::size_t number) {
  const CameraSpec& camera = experiment.camera_at(number);
  const std::string prefix = camera_prefix(experiment, number);
  if (!camera.calibration.empty()) {
    auto calibration = load_calibration(experiment.calibration_file(number));
    if (!calibration) return tl::unexpected(prefix + calibration.error());
    if (calibration->world_from_camera) return calibration;
    return tl::unexpected(
        fmt::format("{}camera.calibration: {} has no world frame, so that pixels cannot be placed on the floor", prefix,
                    camera.calibration));
  }
  if (camera.kind() == CameraKind::synthetic) return shared_floor(experiment, number);
  return tl::unexpected(
      fmt::format("{}camera.calibration is missing: {} needs a calibration file", prefix, camera.source));
}

}  // namespace

tl::expected<vision::Calibration, std::string> camera_calibration(const Experiment& experiment, std::size_t number) {
  auto calibration = calibration_as_filed(experiment, number);
  if (calibration && experiment.tag_size) calibration->tag_size = *experiment.tag_size;
  return calibration;
}

std::vector<int> wanted_tags(const Experiment& experiment, bool every) {
  std::vector<int> wanted;
  wanted.reserve(every ? vision::largest_tag + 1 : experiment.robots.size());
  for (const RobotSpec& robot : experiment.robots) wanted.push_back(robot.tag);
  for (int tag = 0; every && tag <= vision::largest_tag; ++tag)
    if (std::find(wanted.begin(), wanted.end(), tag) == wanted.end()) wanted.push_back(tag);
  return wanted;
}

void update_newest(std::span<const vision::TagPose> seen, std::span<const int> wanted,
                   std::span<core::Measurement> newest) {
  for (const vision::TagPose& tag : seen)
    for (std::size_t i = 0; i < newest.size(); ++i)
      if (wanted[i] == tag.tag) newest[i] = {tag.pose, tag.captured_at, tag.sigma_xy, tag.sigma_theta, tag.how};
}

tl::expected<std::unique_ptr<CameraRig>, std::string> CameraRig::open(const Experiment& experiment, SessionClock& clock,
                                                                      SimulatedWorld& world, bool pictures,
                                                                      std::vector<int> wanted, bool await,
                                                                      std::size_t number,
                                                                      std::shared_ptr<LastSights> sights) {
  auto calibration = camera_calibration(experiment, number);
  if (!calibration) return tl::unexpected(calibration.error());
  if (!sights) sights = std::make_shared<LastSights>(experiment.cameras(), experiment.robots.size());
  std::unique_ptr<CameraRig> rig(
      new CameraRig(experiment, number, clock, world, *calibration, pictures, std::move(wanted), std::move(sights)));
  const CameraSpec& spec = rig->spec_;
  const std::uint64_t seed = experiment.seed + number;  // noise and light of each camera are its own
  if (spec.kind() == CameraKind::synthetic) {
    rig->synthetic_ = std::make_unique<vision::SyntheticCamera>(*calibration, vision::SceneOptions{}, seed);
    if (calibration->row_time > 0.0) world.remember_for(calibration->readout() + spec.stamps_late);
  } else {
    rig->live_ = spec.kind() == CameraKind::live;
    if (const auto opened = rig->open_source(); !opened) {
      if (!await || !rig->live_ || !clock.wall()) return tl::unexpected(rig->prefix_ + opened.error());
      rig->why_awaited_ = opened.error();
      rig->awaited_.store(true, std::memory_order_release);
    }
  }
  return rig;
}

tl::expected<void, std::string> CameraRig::open_source() {
  vision::SourceOptions options{calibration_.width, calibration_.height, experiment_.rate};
  options.readout = calibration_.readout();
  options.trigger = spec_.trigger;
  options.controls = control_settings(spec_);
  options.keep_waiting = [this] { return !ending_.load(std::memory_order_relaxed); };
  auto source = vision::open_source(spec_.source, options);
  if (!source) return tl::unexpected(source.error());
  source_ = std::move(*source);
  return {};
}

/// Until the camera opens or the session ends.
void CameraRig::await_source(const std::stop_token& stop) {
  constexpr std::chrono::milliseconds between_tries(1000), look(50);
  auto next = std::chrono::steady_clock::now() + between_tries;
  while (!stop.stop_requested() && awaited_.load(std::memory_order_relaxed)) {
    std::this_thread::sleep_for(look);
    if (std::chrono::steady_clock::now() < next) continue;
    if (open_source()) awaited_.store(false, std::memory_order_release);
    next = std::chrono::steady_clock::now() + between_tries;
  }
}

CameraRig::CameraRig(const Experiment& experiment, std::size_t number, SessionClock& clock, SimulatedWorld& world,
                     vision::Calibration calibration, bool pictures, std::vector<int> wanted,
                     std::shared_ptr<LastSights> sights)
    : experiment_(experiment),
      spec_(experiment.camera_at(number)),
      number_(number),
      prefix_(camera_prefix(experiment, number)),
      clock_(clock),
      world_(world),
      calibration_(std::move(calibration)),
      wanted_(std::move(wanted)),
      last_sights_(std::move(sights)),
      tracker_(calibration_, {.tags = wanted_}),
      pictures_(pictures),
      poses_(experiment.robots.size()),
      row_poses_(experiment.robots.size()),
      seen_{std::vector<core::Measurement>(wanted_.size()), {}},
      sights_(seen_),
      ready_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      absences_(experiment.robots.size()),
      mark_watch_(calibration_, wanted_tags(experiment)),
      scale_watch_(calibration_),
      rate_watch_(experiment.rate),
      stamp_watch_(experiment.estimation.bridge) {
  why_lost_.resize(experiment.robots.size());
  marks_.watched = mark_watch_.marks() >= vision::MarkWatch::least_seen;
  marks_.known = !marks_.watched;
}

CameraRig::~CameraRig() {
  end();
  if (ready_ >= 0) ::close(ready_);
}

tl::expected<void, std::string> CameraRig::keep(const std::string& path) {
  auto recorder = vision::Recorder::open(path,
                                         {{"PROGRAM", "skein " SKEIN_VERSION},
                                          {"SOURCE", spec_.source},
                                          {"EXPERIMENT", experiment_.source},
                                          {"CALIBRATION", format_calibration(calibration_)}},
                                         spec_.film);
  if (!recorder) return tl::unexpected(recorder.error());
  recorder_ = std::move(*recorder);
  return {};
}

std::function<VideoStatus()> CameraRig::end_film() {
  const std::lock_guard lock(film_mutex_);
  if (!recorder_ || film_ended_) return {};
  film_ended_ = true;
  return [recorder = recorder_] {
    const vision::RecorderStatus status = recorder->finish();
    return VideoStatus{status.written, status.dropped, status.problem};
  };
}

void CameraRig::film_frame(std::string note) {
  if (!recorder_ || film_ended_) return;
  frame_.note = std::move(note);
  if (clock_.wall())
    recorder_->offer(frame_);
  else
    recorder_->add(frame_);  // there is time to wait for the disk
}

VideoStatus CameraRig::video() const {
  if (!recorder_) return {};
  const vision::RecorderStatus status = recorder_->status();
  return {status.written, status.dropped, status.problem};
}

void CameraRig::tell(EventList& events) noexcept {
  for (Event found; events.room() > 0 && found_out_.pop(found);) events.add(found);
  if (!recorder_ || told_of_film_ || !recorder_->broken()) return;
  events.add(events::FilmBroken{});
  told_of_film_ = true;
}

void CameraRig::start() {
  explainer_ = std::jthread([this](const std::stop_token& stop) { explainer(stop); });
  thread_ = std::jthread([this](const std::stop_token& stop) { thread(stop); });
}

vision::SourceStatus CameraRig::camera() const {
  if (awaited_.load(std::memory_order_acquire)) {
    vision::SourceStatus status;
    status.up = false;
    status.reason = why_awaited_;
    return status;
  }
  vision::SourceStatus status = source_ ? source_->status() : vision::SourceStatus{};
  const std::int64_t freezes = freezes_.load(std::memory_order_acquire);
  status.outages += freezes;
  if (frozen_.load(std::memory_order_acquire)) status.up = false;
  if (freezes > 0 && (status.reason.empty() || !status.up))
    status.reason = frozen_reason(frozen_part_.load(std::memory_order_relaxed));
  const std::lock_guard lock(absence_mutex_);
  if (unusable_.empty()) return status;
  status.up = false;
  status.reason = unusable_;
  return status;
}

void CameraRig::end() {
  ending_.store(true, std::memory_order_relaxed);
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  explainer_.request_stop();
  if (explainer_.joinable()) explainer_.join();
  if (const auto complete = end_film()) static_cast<void>(complete());
}

void CameraRig::thread(const std::stop_token& stop) {
  ask_for_priority(camera_priority);  // refused: the control thread's was as well, and says so
  try {
    await_source(stop);
    // Half a period out of step with the control thread, as far as a camera without a trigger can be.
    double deadline = clock_.now() + 0.5 * experiment_.period();
    while (!stop.stop_requested()) {
      if (!live_) {
        deadline += experiment_.period() * std::max(1.0, std::ceil((clock_.now() - deadline) / experiment_.period()));
        std::this_thread::sleep_until(clock_.at(deadline));
      }
      if (!capture()) break;
      work_off();
    }
  } catch (const std::exception& error) {
    reason_ = fmt::format("camera: {}", error.what());
  }
  if (!reason_.empty()) failed_.store(true, std::memory_order_release);
}

void CameraRig::process_frame() {
  if (failed()) return;
  if (capture())
    work_off();
  else
    failed_.store(true, std::memory_order_release);
}

/// The only place that knows of camera.latency: film, tracker and tick get the corrected time. Nothing is captured
/// after it has arrived.
bool CameraRig::capture() {
  repeat_watch_.keep(frame_);
  if (!(synthetic_ ? render() : receive())) return false;
  frame_.captured_at = std::min(frame_.captured_at - spec_.latency, seen_.times.arrived_at);
  seen_.times.captured_at = frame_.captured_at;
  return true;
}

/// Each robot is drawn where it was when the row of its tag was read. Where it is in the picture tells the row.
void CameraRig::poses_at_their_rows(double first_row) {
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const double v = pixel(poses_[i].x, poses_[i].y)[1];
    if (std::isnan(v)) continue;
    world_.poses_at(first_row + calibration_.row_time * std::clamp(v, 0.0, double(calibration_.height)), row_poses_);
    poses_[i] = row_poses_[i];
  }
}

bool CameraRig::render() {
  const double now = clock_.now();
  if (spec_.lost_at && now >= *spec_.lost_at) {
    reason_ = "the synthetic camera is lost (camera.lost_at)";
    return false;
  }
  world_.advance(now);
  // A rolling shutter's frame is there when its last row has been read; its stamp is of the first one.
  const double stamp = now - calibration_.readout(), first_row = stamp - spec_.stamps_late;
  if (first_row < now)
    world_.poses_at(first_row, poses_);
  else
    world_.poses(poses_);
  if (calibration_.row_time > 0.0) poses_at_their_rows(first_row);
  tags_.clear();
  for (const vision::FloorMark& mark : calibration_.marks) {
    if (mark.tag < 0) continue;
    const bool moved = tags_.empty() && spec_.mark_moved_at && now >= *spec_.mark_moved_at;
    tags_.push_back({.tag = mark.tag,
                     .pose = {mark.x + (moved ? mark_moved_by : 0.0), mark.y, 0.0},
                     .size = mark.size > 0.0 ? mark.size : calibration_.tag_size,
                     .lifted = mark.z - calibration_.tag_height,
                     .bare = true});
  }
  for (std::size_t i = 0; i < poses_.size(); ++i)
    if (!std::isnan(poses_[i].x)) tags_.push_back({experiment_.robots[i].tag, poses_[i], calibration_.tag_size});
  if (spec_.bump_at && now >= *spec_.bump_at) {
    const double since = now - *spec_.bump_at;
    const double share = since < spec_.bump_time ? since / spec_.bump_time : 1.0;
    if (share != bumped_) {
      vision::CameraPose pose = *vision::tilted(calibration_, share * spec_.bump).world_from_camera;
      pose.position.z() += share * spec_.raise;
      synthetic_->hang(pose);
    }
    bumped_ = share;
  }
  if (spec_.defocus_at && now >= *spec_.defocus_at) {
    constexpr double step = 0.05;  // the whole floor is blurred anew at each [px]
    const double since = now - *spec_.defocus_at;
    const double sharp = vision::SceneOptions{}.blur_px;
    const double share = since < spec_.defocus_time ? since / spec_.defocus_time : 1.0;
    const double blur = sharp + step * std::floor(share * (spec_.defocus - sharp) / step);
    if (blur != blur_) synthetic_->focus(blur);
    blur_ = blur;
  }
  synthetic_->render(tags_, stamp, frame_);
  freeze(now);
  seen_.times = {stamp, clock_.now(), none, none};
  seen_.times.grey_at = seen_.times.arrived_at;
  return true;
}

/// For practice. The whole picture stands still; a part of it is what a driver with four buffers has in each of them
/// from before, if its transfers break off.
void CameraRig::freeze(double now) {
  if (!spec_.freeze_at) return;
  std::vector<std::uint8_t>& still = stills_[spec_.freeze_part < 1.0 ? rendered_++ % stills_.size() : 0];
  const bool frozen = now >= *spec_.freeze_at && !(spec_.freeze_for && now >= *spec_.freeze_at + *spec_.freeze_for);
  if (!frozen || still.empty()) {
    still = frame_.grey;
    return;
  }
  const auto from = static_cast<std::ptrdiff_t>(static_cast<double>(still.size()) * (1.0 - spec_.freeze_part));
  std::copy(still.begin() + from, still.end(), frame_.grey.begin() + from);
}

bool CameraRig::receive() {
  const auto read = source_->read(frame_);
  if (!read)
    reason_ = read.error();
  else if (!*read)
    reason_ = fmt::format("{}: the stream is at its end", spec_.source);
  if (!reason_.empty()) return false;
  const double now = clock_.now();
  frame_.captured_at = live_ ? clock_.from_monotonic(frame_.captured_at) : now;
  const bool stamped = live_ && frame_.arrived_at > 0.0;
  seen_.times = {frame_.captured_at, stamped ? clock_.from_monotonic(frame_.arrived_at) : now, now, none};
  return true;
}

vision::MissingTag CameraRig::missing_tag(std::size_t robot) const {
  const core::Measurement& tag = seen_.tags[robot];
  return {.tag = wanted_[robot],
          .last = ever_seen(tag) ? std::optional(tag.pose) : std::nullopt,
          .lifted_from = tracker_.lifted_from(wanted_[robot]),
          .blur = focus_watch_.out_of_focus()};
}

void CameraRig::answer_question() {
  const std::lock_guard lock(question_mutex_);
  if (!asked_) return;
  asked_ = false;
  answer_.frame = frame_;
  answer_.missing.clear();
  for (std::size_t i = 0; i < experiment_.robots.size(); ++i) {
    const core::Measurement& tag = seen_.tags[i];
    if (tag.captured_at >= frame_.captured_at) continue;
    const double elsewhere = last_sights_->newest(i);
    if (elsewhere > tag.captured_at && elsewhere >= frame_.captured_at - experiment_.estimation.bridge) continue;
    answer_.missing.push_back(missing_tag(i));
  }
  answered_.notify_all();
}

std::vector<UnseenTag> CameraRig::why_not_seen() {
  constexpr auto patience = std::chrono::seconds(1);
  std::unique_lock lock(question_mutex_);
  asked_ = true;
  if (!answered_.wait_for(lock, patience, [this] { return !asked_; })) {
    asked_ = false;
    return {};
  }
  const Question question = answer_;
  lock.unlock();
  if (!fits(question.frame)) return {{.sentence = size_sentence(question.frame)}};
  std::vector<UnseenTag> unseen;
  for (const vision::TagDiagnosis& tag : vision::diagnose(question.frame, calibration_, question.missing))
    unseen.push_back(unseen_tag(question.frame, tag));
  return unseen;
}

std::size_t CameraRig::robot_of(int tag) const {
  return static_cast<std::size_t>(std::find(wanted_.begin(), wanted_.end(), tag) - wanted_.begin());
}

UnseenTag CameraRig::unseen_tag(const vision::Frame& frame, const vision::TagDiagnosis& tag) const {
  UnseenTag unseen{tag.tag, tag.why, vision::sentence(tag, calibration_)};
  if (tag.size > 0.0) unseen.size = tag.size;
  vision::Frame crop = vision::picture_of(frame, tag);
  if (crop.width == 0) return unseen;
  unseen.picture = std::make_shared<const Picture>(Picture{crop.width, crop.height, std::move(crop.grey)});
  if (crops_)
    unseen.file = crops_->add({robot_of(tag.tag), crop_file(tag.tag, number_, experiment_.cameras()),
                               prefix_ + unseen.sentence, unseen.picture});
  return unseen;
}

/// For each robot that was seen and has not been seen for half a second, the reason is requested once, from the camera
/// that saw it last. One frame serves for all of them.
void CameraRig::explain_absences() {
  constexpr double between = 2.0, between_searches = 5.0;  // [s]
  const double now = frame_.captured_at;
  missing_.clear();
  // A robot that was never seen is looked for again and again, since the operator may correct tags, light and camera
  // meanwhile.
  const bool search = clock_.wall() && !(now < next_search_);
  if (search) next_search_ = now + between_searches;
  for (std::size_t i = 0; i < absences_.size(); ++i) {
    const core::Measurement& tag = seen_.tags[i];
    const bool ever = ever_seen(tag);
    if (tag.captured_at >= now || (!ever && search)) absences_[i].seen(now);
    if (absences_[i].due(now) && last_sights_->newest(i) <= tag.captured_at) missing_.push_back(missing_tag(i));
  }
  if (missing_.empty() || now < next_absence_) return;
  if (clock_.wall()) {
    const std::unique_lock lock(absence_mutex_, std::try_to_lock);
    if (!lock || absence_) return;
    absence_.emplace(Question{frame_, missing_});
    absent_.notify_all();
    next_absence_ = now + between;
  }
  for (std::size_t i = 0; i < absences_.size(); ++i)
    for (const vision::MissingTag& tag : missing_)
      if (wanted_[i] == tag.tag) absences_[i].ask();
  if (!clock_.wall()) explain(frame_, missing_);
}

void CameraRig::explain(const vision::Frame& frame, std::span<const vision::MissingTag> missing) {
  if (!fits(frame)) return;
  std::vector<UnseenTag> unseen;
  for (const vision::TagDiagnosis& tag : vision::diagnose(frame, calibration_, missing))
    unseen.push_back(unseen_tag(frame, tag));
  const std::lock_guard lock(absence_mutex_);
  for (const UnseenTag& tag : unseen) {
    const std::size_t robot = robot_of(tag.tag);
    why_lost_[robot] = tag;
    const bool ever = std::any_of(missing.begin(), missing.end(),
                                  [&](const vision::MissingTag& one) { return one.tag == tag.tag && one.last; });
    if (!ever) continue;  // it is no news that it is not there
    found_out_.push(events::NotSeen{robot, tag.why});
    alarms_.push_back(fmt::format("{}robot {} is lost: {}", prefix_, robot + 1, tag.text()));
  }
}

std::vector<UnseenTag> CameraRig::why_lost() const {
  const std::lock_guard lock(absence_mutex_);
  return why_lost_;
}

/// Now and then, and soon again where a sight is to be confirmed.
void CameraRig::watch_marks() {
  if (!marks_.watched || !fits_ || frame_.captured_at < next_look_.load(std::memory_order_acquire)) return;
  // The first ones, on which a start waits, are not left to a thread that a busy machine lets wait: robots still stand.
  constexpr int most_own_looks = 4;
  if (!clock_.wall() || (marks().sentence.empty() && own_looks_++ < most_own_looks)) return look_at_marks(frame_);
  const std::unique_lock lock(absence_mutex_, std::try_to_lock);
  if (!lock || floor_) return;
  floor_.emplace(frame_);
  absent_.notify_all();
}

void CameraRig::look_at_marks(const vision::Frame& frame) {
  constexpr double between = 2.0, in_doubt = 0.5;  // [s]
  next_look_.store(frame.captured_at + between, std::memory_order_release);
  const bool was_blind = mark_watch_.blind() != nullptr;
  const bool news = mark_watch_.update(frame);
  if (mark_watch_.doubts()) next_look_.store(frame.captured_at + in_doubt, std::memory_order_release);
  const std::optional<vision::MarkSight>& sight = mark_watch_.known();
  if (!sight) return;
  const vision::MarkSight* blind = mark_watch_.blind();
  const std::string sentence = vision::sentence(blind ? *blind : *sight);
  const bool moved = sight->state == vision::MarkSight::State::camera_moved;
  const events::CameraMoved event{.camera = experiment_.cameras() == 1 ? events::only_camera : number_,
                                  .by = sight->by,
                                  .turn = sight->turn,
                                  .marks = sight->moved.size()};
  const bool well = sight->state == vision::MarkSight::State::in_place;
  const bool goes_on = experiment_.failure.camera_moved == FailureSpec::CameraMoved::go_on;
  {
    const std::lock_guard lock(absence_mutex_);
    marks_.known = vision::tells(sight->state);
    marks_.moved = moved ? std::optional(event) : std::nullopt;
    marks_.sentence = prefix_ + sentence;
    // The part that stops the robots reports that they are stopped.
    if (news && !well && (!moved || goes_on)) alarms_.push_back(prefix_ + sentence);
    if (blind && !was_blind)
      alarms_.push_back(fmt::format("{}{}; it has been so for {:g} s: clear the marks, or calibrate the floor anew",
                                    prefix_, sentence, vision::MarkWatch::patience));
    if (news && moved) found_out_.push(event);
  }
}

/// Whether they are as large and as sharp as they should be, and stay so.
void CameraRig::watch_tags() {
  const double now = frame_.captured_at;
  const std::array sentences = {scale_watch_.update(now, tracker_.stretch()),
                                scale_watch_.update_change(now, tracker_.scale_change()),
                                focus_watch_.update(now, tracker_.blur())};
  const auto& moved = scale_watch_.moved();
  const std::lock_guard lock(absence_mutex_);
  for (const std::string& sentence : sentences)
    if (!sentence.empty()) alarms_.push_back(prefix_ + sentence);
  if (moved.has_value() == scaled_.has_value()) return;
  scaled_.reset();
  if (!moved) return;
  scaled_ = events::CameraMoved{
      .camera = experiment_.cameras() == 1 ? events::only_camera : number_, .tags = moved->tags, .scale = moved->by};
  found_out_.push(*scaled_);
}

/// What the camera does not do as it was asked to, and how fast its frames come.
void CameraRig::watch_source() {
  if (!live_) return;
  std::vector<std::string> sentences = source_->status().notices;
  sentences.push_back(rate_watch_.update(frame_.captured_at));
  const std::lock_guard lock(absence_mutex_);
  for (const std::string& sentence : sentences)
    if (!sentence.empty() && told_of_source_.insert(sentence).second) alarms_.push_back(prefix_ + sentence);
}

MarksStatus CameraRig::marks() const {
  const std::lock_guard lock(absence_mutex_);
  MarksStatus status = marks_;
  if (!status.moved) status.moved = scaled_;
  return status;
}

void CameraRig::explainer(const std::stop_token& stop) {
  constexpr int niceness = 5;  // of this thread: behind camera and tick, but end() waits for it on a busy machine too
  ::setpriority(PRIO_PROCESS, 0, niceness);
  std::unique_lock lock(absence_mutex_);
  // The question stays where it is while it is worked on: so there is one at a time.
  const auto work_on = [&](auto& question, const char* what, auto&& answer) {
    if (!question) return;
    lock.unlock();
    try {
      answer(*question);
    } catch (const std::exception& error) {
      const std::lock_guard again(absence_mutex_);
      alarms_.push_back(fmt::format("{} cannot be determined: {}", what, error.what()));
    }
    lock.lock();
    question.reset();
  };
  while (absent_.wait(lock, stop, [this] { return absence_ || floor_; })) {
    work_on(absence_, "the reason why a tag is not seen",
            [this](const Question& question) { explain(question.frame, question.missing); });
    work_on(floor_, "whether the camera has moved", [this](const vision::Frame& frame) { look_at_marks(frame); });
  }
}

std::vector<std::string> CameraRig::alarms() {
  const std::lock_guard lock(absence_mutex_);
  return std::exchange(alarms_, {});
}

bool CameraRig::fits(const vision::Frame& frame) const {
  return frame.width == calibration_.width && frame.height == calibration_.height;
}

std::string CameraRig::size_sentence(const vision::Frame& frame) const {
  return fmt::format("the camera's frames are {}x{} px, but the calibration holds for {}x{}", frame.width, frame.height,
                     calibration_.width, calibration_.height);
}

/// Frames of another size show nothing, and robots do not drive by poses that are too old, whatever the reason.
void CameraRig::judge_frame() {
  const bool changed = stamp_watch_.update(frame_.captured_at, seen_.times.arrived_at);
  const bool fitted = std::exchange(fits_, fits(frame_));
  if (!changed && fits_ == fitted) return;
  const std::lock_guard lock(absence_mutex_);
  const std::string before = std::exchange(unusable_, fits_ ? stamp_watch_.fault() : size_sentence(frame_));
  if (before == unusable_ || experiment_.cameras() > 1) return;  // Cameras tells it of each
  alarms_.push_back(unusable_.empty() ? std::string("the camera's frames can be used again")
                                      : fmt::format("the camera's frames cannot be used: {}: robots stand", unusable_));
}

/// The picture is the last one's, with another time stamp, or a part of it is an older one's: nothing is known of
/// where the robots, or some of them, are now. Films and pictures may repeat frames, and compressed ones show the same
/// to the bit while nothing moves.
bool CameraRig::repeats() {
  if (spec_.kind() == CameraKind::recorded) return false;
  const bool same = repeat_watch_.repeats(frame_), frozen = repeat_watch_.frozen();
  if (frozen == frozen_.load(std::memory_order_relaxed)) return same;
  if (frozen) {
    frozen_part_.store(repeat_watch_.part(), std::memory_order_relaxed);
    freezes_.fetch_add(1, std::memory_order_release);
  }
  frozen_.store(frozen, std::memory_order_release);
  if (experiment_.cameras() > 1) return same;  // Cameras tells it of each
  const std::lock_guard lock(absence_mutex_);
  alarms_.push_back(frozen ? fmt::format("the camera is frozen: {} (a driver that hangs, a transfer that breaks off, "
                                         "a capture program whose input has stopped): robots stand until it changes",
                                         frozen_reason(repeat_watch_.part()))
                           : "the camera delivers new pictures again");
  return same;
}

void CameraRig::work_off() {
  judge_frame();
  if (repeats()) {
    const std::lock_guard lock(film_mutex_);
    return film_frame(repeated_note);
  }
  elsewhere_.clear();
  for (std::size_t i = 0; i < experiment_.robots.size(); ++i)
    if (const auto pose = last_sights_->elsewhere(number_, i, frame_.captured_at))
      elsewhere_.push_back({wanted_[i], *pose});
  update_newest(tracker_.process(frame_, elsewhere_), wanted_, seen_.tags);
  for (std::size_t i = 0; i < experiment_.robots.size(); ++i) last_sights_->saw(number_, i, seen_.tags[i]);
  answer_question();
  explain_absences();
  watch_marks();
  // A film that ends while the tick has these poses already, and their frame is not in the film, would lack a frame of
  // the run.
  const std::lock_guard lock(film_mutex_);
  seen_.times.ready_at = clock_.now();
  sights_.draft() = seen_;
  sights_.publish();
  ready_at_.store(seen_.times.ready_at, std::memory_order_release);
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(ready_, &one, sizeof one);  // full means rung already
  watch_tags();                                                             // the tick waits for poses, not for these
  watch_source();
  film_frame(note_of(elsewhere_));
  if (!pictures_) return;
  Picture& picture = picture_.draft();
  picture.width = frame_.width;
  picture.height = frame_.height;
  picture.grey = frame_.grey;
  picture_.publish();
}

bool CameraRig::newest(std::span<core::Measurement> measurements, FrameTimes& times) noexcept {
  if (!sights_.take()) return false;
  std::copy_n(sights_.value().tags.begin(), std::min(measurements.size(), wanted_.size()), measurements.begin());
  times = sights_.value().times;
  return true;
}

void CameraRig::wait_for_frame(double since, double until) noexcept {
  for (double now = clock_.now(); ready_at_.load(std::memory_order_acquire) < since && now < until;
       now = clock_.now()) {
    std::uint64_t rings = 0;
    [[maybe_unused]] const auto read = ::read(ready_, &rings, sizeof rings);
    if (ready_at_.load(std::memory_order_acquire) >= since) return;
    const timespec timeout{.tv_sec = 0, .tv_nsec = static_cast<long>(std::min(until - now, 0.9) * 1e9)};
    pollfd ready{.fd = ready_, .events = POLLIN, .revents = 0};
    ::ppoll(&ready, 1, &timeout, nullptr);
  }
}

void CameraRig::watch_for_frame(double since, double until) const noexcept {
  while (ready_at_.load(std::memory_order_acquire) < since && clock_.now() < until) {
  }
}

bool CameraRig::picture(Picture& out) {
  if (!picture_.take()) return false;
  out = picture_.value();
  return true;
}

std::array<double, 2> CameraRig::pixel(double x, double y) const {
  const auto p = vision::pixel_from_world(calibration_, {x, y, calibration_.tag_height});
  return p ? std::array{p->x(), p->y()} : std::array{none, none};
}

}  // namespace skein::app
