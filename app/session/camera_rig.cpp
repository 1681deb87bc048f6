#include "app/session/camera_rig.h"

#include <fmt/format.h>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "app/experiment/control_settings.h"
#include "app/run/timing.h"
#include "app/session/camera_film.h"
#include "app/session/experiment_cameras.h"
#include "app/session/picture_copy.h"
#include "vision/sources/open_source.h"

namespace skein::app {

namespace {

/// `part`: of the picture's height.
std::string frozen_reason(double part) {
  if (part == 1.0) return "it delivers the same picture again and again";
  return fmt::format("{:.0f} % of its picture show what older ones showed", 100.0 * part);
}

}  // namespace

tl::expected<std::unique_ptr<CameraRig>, std::string> CameraRig::open(const Experiment& experiment, SessionClock& clock,
                                                                      SimulatedWorld& world, bool pictures,
                                                                      std::vector<int> wanted, bool await,
                                                                      std::size_t number,
                                                                      std::shared_ptr<LastSights> sights) {
  auto calibration = camera_calibration(experiment, number);
  if (!calibration) return tl::unexpected(calibration.error());
  if (!sights) sights = std::make_shared<LastSights>(experiment.cameras(), experiment.robots.size());
  std::unique_ptr<CameraRig> rig(
      new CameraRig(experiment, number, clock, *calibration, pictures, std::move(wanted), std::move(sights)));
  const CameraSpec& spec = rig->spec_;
  const std::uint64_t seed = experiment.seed + number;  // noise and light of each camera are its own
  if (spec.kind() == CameraKind::synthetic) {
    rig->rendered_ = std::make_unique<RenderedCamera>(experiment, spec, rig->calibration_, seed, world);
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

CameraRig::CameraRig(const Experiment& experiment, std::size_t number, SessionClock& clock,
                     vision::Calibration calibration, bool pictures, std::vector<int> wanted,
                     std::shared_ptr<LastSights> sights)
    : experiment_(experiment),
      spec_(experiment.camera_at(number)),
      number_(number),
      prefix_(camera_prefix(experiment, number)),
      clock_(clock),
      calibration_(std::move(calibration)),
      wanted_(std::move(wanted)),
      last_sights_(std::move(sights)),
      tracker_(calibration_, {.tags = wanted_}),
      findings_(experiment, number, calibration_, wanted_, tracker_, *last_sights_, clock.wall()),
      pictures_(pictures),
      seen_{std::vector<core::Measurement>(wanted_.size()), {}},
      sights_(seen_),
      ready_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      rate_watch_(experiment.rate),
      stamp_watch_(experiment.estimation.bridge) {}

void CameraPace::wait() {
  deadline_ += period_ * std::max(1.0, std::ceil((clock_.now() - deadline_) / period_));
  std::this_thread::sleep_until(clock_.at(deadline_));
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
  for (Event found; events.room() > 0 && findings_.take(found);) events.add(found);
  if (!recorder_ || told_of_film_ || !recorder_->broken()) return;
  events.add(events::FilmBroken{});
  told_of_film_ = true;
}

void CameraRig::start(bool alone) {
  findings_.start();
  if (alone) thread_ = std::jthread([this](const std::stop_token& stop) { thread(stop); });
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
  const std::lock_guard lock(unusable_mutex_);
  if (unusable_.empty()) return status;
  status.up = false;
  status.reason = unusable_;
  return status;
}

void CameraRig::end() {
  ending_.store(true, std::memory_order_relaxed);
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  findings_.end();
  if (const auto complete = end_film()) static_cast<void>(complete());
}

void CameraRig::thread(const std::stop_token& stop) {
  ask_for_priority(camera_priority);  // refused: the control thread's was as well, and says so
  await_source(stop);
  CameraPace pace(clock_, experiment_.period());
  while (!stop.stop_requested()) {
    if (!live_) pace.wait();
    if (spec_.kind() == CameraKind::recorded && !next_in_film()) return;
    if (!step(clock_.now())) return;
  }
}

bool CameraRig::step(double now) {
  try {
    if (capture(now)) work_off();
  } catch (const std::exception& error) {
    reason_ = fmt::format("camera: {}", error.what());
  }
  if (!reason_.empty()) failed_.store(true, std::memory_order_release);
  return reason_.empty();
}

void CameraRig::process_frame(double now) {
  if (!failed()) step(now);
}

/// The only place that knows of camera.latency: film, tracker and tick get the corrected time. Nothing is captured
/// after it has arrived: the operator is told of a clock that says so.
bool CameraRig::capture(double now) {
  if (!(rendered_ ? render() : receive(now))) return false;
  const double captured_at = frame_.captured_at - spec_.latency, arrived_at = seen_.times.arrived_at;
  if (std::string ahead = stamp_watch_.update_ahead(captured_at - arrived_at, arrived_at); !ahead.empty())
    findings_.tell(prefix_ + ahead);
  frame_.captured_at = seen_.times.captured_at = std::min(captured_at, arrived_at);
  return true;
}

bool CameraRig::render() {
  const double now = clock_.now();
  if (rendered_->is_lost(now)) {
    reason_ = "the synthetic camera is lost (camera.lost_at)";
    return false;
  }
  repeat_watch_.keep(frame_);
  rendered_->render(now, frame_);
  seen_.times = {frame_.captured_at, clock_.now(), none, none};
  seen_.times.grey_at = seen_.times.arrived_at;
  return true;
}

bool CameraRig::read() {
  repeat_watch_.keep(frame_);
  const auto read = source_->read(frame_);
  if (!read)
    reason_ = read.error();
  else if (!*read)
    reason_ = fmt::format("{}: the stream is at its end{}", spec_.source, never_seen());
  return reason_.empty();
}

std::optional<double> CameraRig::next_in_film() {
  if (failed()) return {};
  try {
    read_ahead_ = read_ahead_ || read();
  } catch (const std::exception& error) {
    reason_ = fmt::format("camera: {}", error.what());
  }
  if (read_ahead_) return frame_.captured_at;
  failed_.store(true, std::memory_order_release);
  return {};
}

/// A film's frames are there when they are due, however late a busy machine works them off.
bool CameraRig::receive(double now) {
  if (!std::exchange(read_ahead_, false) && !read()) return false;
  const double arrived_at = live_ ? clock_.now() : now;
  frame_.captured_at = live_ ? clock_.from_monotonic(frame_.captured_at) : now;
  const bool stamped = live_ && frame_.arrived_at > 0.0;
  seen_.times = {frame_.captured_at, stamped ? clock_.from_monotonic(frame_.arrived_at) : arrived_at, arrived_at, none};
  return true;
}

/// A film that ends while a run still waits for its robots never shows some of them; its last frame tells why.
std::string CameraRig::never_seen() const {
  std::string all;
  std::vector<vision::MissingTag> missing;
  for (std::size_t i = 0; i < experiment_.robots.size(); ++i) {
    if (last_sights_->newest(i) > core::Measurement::never) continue;
    all += fmt::format("{} {} (robot {})", all.empty() ? "; tags never seen:" : ",", wanted_[i], i + 1);
    missing.push_back(findings_.missing_tag(i, seen_.tags[i]));
  }
  if (missing.empty() || frame_.width == 0) return all;
  for (const UnseenTag& tag : findings_.why_not_seen(frame_, missing))
    if (tag.why != core::NotSeen::not_found) all += "; " + tag.text();
  return all;
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
    answer_.missing.push_back(findings_.missing_tag(i, tag));
  }
  answered_.notify_all();
}

std::vector<UnseenTag> CameraRig::why_not_seen() {
  constexpr auto patience = std::chrono::seconds(5);  // the run ends in any case, and a busy machine takes seconds
  std::unique_lock lock(question_mutex_);
  asked_ = true;
  if (!answered_.wait_for(lock, patience, [this] { return !asked_; })) {
    asked_ = false;
    return {};
  }
  const Question question = answer_;
  lock.unlock();
  return findings_.why_not_seen(question.frame, question.missing);
}

/// What the camera does not do as it was asked to, and how fast its frames come; of a film, how it is read.
void CameraRig::watch_source() {
  if (!source_) return;
  if (!live_) return findings_.tell_once(source_->status().remarks);
  std::vector<std::string> sentences = source_->status().notices;
  sentences.push_back(rate_watch_.update(frame_.captured_at));
  findings_.tell_once(sentences);
}

/// Frames of another size show nothing, and robots do not drive by poses that are too old, whatever the reason.
void CameraRig::judge_frame() {
  const bool changed = stamp_watch_.update(frame_.captured_at, seen_.times.arrived_at);
  const std::string size = size_fault(frame_, calibration_);
  const bool fits = size.empty(), fitted = std::exchange(fits_, fits);
  if (!changed && fits == fitted) return;
  const std::string fault = fits ? stamp_watch_.fault() : size;
  {
    const std::lock_guard lock(unusable_mutex_);
    if (fault == std::exchange(unusable_, fault)) return;
  }
  if (experiment_.cameras() > 1) return;  // Cameras tells it of each
  findings_.tell(fault.empty() ? std::string("the camera's frames can be used again")
                               : fmt::format("the camera's frames cannot be used: {}: robots stand", fault));
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
  findings_.tell(frozen ? fmt::format("the camera is frozen: {} (a driver that hangs, a transfer that breaks off, "
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
  findings_.watch_absences(frame_, seen_.tags, elsewhere_);
  findings_.watch_marks(frame_);
  // A film that ends while the tick has these poses already, and their frame is not in the film, would lack a frame of
  // the run.
  const std::lock_guard lock(film_mutex_);
  seen_.times.ready_at = clock_.now();
  sights_.draft() = seen_;
  sights_.publish();
  frames_.fetch_add(1, std::memory_order_relaxed);
  ready_at_.store(seen_.times.ready_at, std::memory_order_release);
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(ready_, &one, sizeof one);  // full means rung already
  findings_.watch_tags(frame_.captured_at);                                 // the tick waits for poses, not for these
  watch_source();
  film_frame(note_of(elsewhere_));
  if (!pictures_) return;
  copy_pixels(frame_, picture_.draft());
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
