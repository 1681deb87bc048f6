#include "app/session/cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "app/run/timing.h"
#include "app/session/camera_film.h"

namespace skein::app {

tl::expected<std::unique_ptr<Cameras>, std::string> Cameras::open(const Experiment& experiment, SessionClock& clock,
                                                                  SimulatedWorld& world, bool pictures,
                                                                  const std::vector<int>& wanted, bool await) {
  std::unique_ptr<Cameras> cameras(new Cameras(experiment, clock));
  const auto sights = std::make_shared<LastSights>(experiment.cameras(), experiment.robots.size());
  for (std::size_t k = 0; k < cameras->all_.size(); ++k) {
    auto rig = CameraRig::open(experiment, clock, world, pictures, wanted, await, k, sights);
    if (!rig) return tl::unexpected(rig.error());
    cameras->all_[k].rig = std::move(*rig);
    cameras->all_[k].film = experiment.cameras() > 1 && experiment.camera_at(k).kind() == CameraKind::recorded;
  }
  return cameras;
}

tl::expected<void, std::string> Cameras::keep(const std::string& path) {
  const std::vector<std::string> paths = film_paths(experiment_, path);
  for (std::size_t k = 0; k < all_.size(); ++k)
    if (auto begun = all_[k].rig->keep(paths[k]); !begun) return begun;
  return {};
}

void Cameras::keep_crops(TagCrops* crops) {
  for (Each& camera : all_) camera.rig->keep_crops(crops);
}

void Cameras::start() {
  for (Each& camera : all_) camera.rig->start(!camera.film);
  if (std::none_of(all_.begin(), all_.end(), [](const Each& camera) { return camera.film; })) return;
  films_ = std::jthread([this](const std::stop_token& stop) {
    ask_for_priority(camera_priority);  // refused: the control thread's was as well, and says so
    CameraPace pace(clock_, experiment_.period());
    while (!stop.stop_requested()) {
      pace.wait();
      process_frames();
    }
  });
}

void Cameras::end() {
  films_.request_stop();
  if (films_.joinable()) films_.join();
  for (Each& camera : all_) camera.rig->end();
}

void Cameras::process_frames() {
  double moment = std::numeric_limits<double>::infinity();  // by the films' own times
  for (Each& camera : all_)
    if (camera.film) moment = std::min(moment, camera.rig->next_in_film().value_or(moment));
  moment += 0.5 * experiment_.period();
  const double now = clock_.now();
  for (Each& camera : all_) {
    const bool due = camera.film ? camera.rig->next_in_film().value_or(moment) <= moment : !clock_.wall();
    if (due) camera.rig->process_frame(now);
  }
}

CameraRig& Cameras::lead() const noexcept {
  const auto runs = std::find_if(all_.begin(), all_.end(), [](const Each& camera) { return !camera.rig->failed(); });
  return runs == all_.end() ? *all_.front().rig : *runs->rig;
}

bool Cameras::newest(std::span<core::Measurement> measurements, FrameTimes& times) noexcept {
  const CameraRig* const leading = &lead();
  const std::size_t each = measurements.size() / all_.size();
  bool looked = false;
  for (std::size_t k = 0; k < all_.size(); ++k) {
    FrameTimes of_frame;
    if (!all_[k].rig->newest(measurements.subspan(k * each, each), of_frame) || all_[k].rig.get() != leading) continue;
    times = of_frame;
    looked = true;
  }
  return looked;
}

void Cameras::tell(EventList& events) noexcept {
  for (std::size_t k = 0; k < all_.size(); ++k) {
    Each& camera = all_[k];
    camera.rig->tell(events);
    const bool lost = camera.lost.load(std::memory_order_acquire);
    if (lost == camera.told || events.room() == 0) continue;
    camera.told = lost;
    events.add(lost ? Event(events::CameraLost{k}) : Event(events::CameraFound{k}));
  }
}

namespace {

void add(VideoStatus& all, const VideoStatus& one) {
  all.frames += one.frames;
  all.dropped += one.dropped;
  if (all.problem.empty()) all.problem = one.problem;
}

}  // namespace

VideoStatus Cameras::video() const {
  VideoStatus all;
  for (const Each& camera : all_) add(all, camera.rig->video());
  return all;
}

std::function<VideoStatus()> Cameras::end_film() {
  std::vector<std::function<VideoStatus()>> each;
  for (const Each& camera : all_)
    if (auto complete = camera.rig->end_film()) each.push_back(std::move(complete));
  if (each.empty()) return {};
  return [each = std::move(each)] {
    VideoStatus all;
    for (const auto& complete : each) add(all, complete());
    return all;
  };
}

vision::SourceStatus Cameras::status() const {
  vision::SourceStatus all = all_.front().rig->camera();
  std::string down;
  for (std::size_t k = 0; all_.size() > 1 && k < all_.size(); ++k) {
    vision::SourceStatus one = all_[k].rig->camera();
    const std::string prefix = camera_prefix(experiment_, k);
    if (k == 0) all = {};
    if (all_[k].rig->failed()) {
      one.up = false;
      one.reason = all_[k].rig->reason();
      ++one.outages;
    }
    for (std::string& notice : one.notices) all.notices.push_back(prefix + notice);
    for (const std::string& automatic : one.automatics) all.automatics.push_back(prefix + automatic);
    all.outages += one.outages;
    all.damaged += one.damaged;
    all.passed_over += one.passed_over;
    all.up = all.up && one.up;
    if (all.reason.empty() && !one.reason.empty()) all.reason = prefix + one.reason;
    if (!one.up) down += (down.empty() ? "" : "; ") + prefix + one.reason;
  }
  if (!down.empty()) all.reason = std::move(down);  // not that of an outage that is over
  return all;
}

/// What a camera sees of a tag says more than that another one finds nothing of it.
std::vector<UnseenTag> Cameras::why_not_seen() {
  std::vector<std::pair<std::size_t, UnseenTag>> all;
  for (std::size_t k = 0; k < all_.size(); ++k)
    for (UnseenTag& tag : all_[k].rig->why_not_seen()) all.emplace_back(k, std::move(tag));
  std::vector<UnseenTag> unseen;
  for (auto one = all.begin(); one != all.end(); ++one) {
    const UnseenTag& tag = one->second;
    const auto same = [&](const auto& other) { return other.second.tag == tag.tag; };
    const auto tells = [&](const auto& other) { return same(other) && other.second.why != core::NotSeen::not_found; };
    const bool nothing = tag.tag >= 0 && tag.why == core::NotSeen::not_found;
    // Where no camera finds anything, the first says so for all.
    if (nothing && (std::any_of(all.begin(), all.end(), tells) || std::any_of(all.begin(), one, same))) continue;
    unseen.push_back(tag);
    if (!nothing) unseen.back().sentence.insert(0, camera_prefix(experiment_, one->first));
  }
  return unseen;
}

std::vector<UnseenTag> Cameras::why_lost() const {
  std::vector<UnseenTag> unseen(experiment_.robots.size());
  for (std::size_t k = 0; k < all_.size(); ++k) {
    std::vector<UnseenTag> of_this = all_[k].rig->why_lost();
    for (std::size_t i = 0; i < unseen.size(); ++i) {
      const bool tells = of_this[i].why != core::NotSeen::not_found;
      if (!tells && !unseen[i].sentence.empty()) continue;
      unseen[i] = std::move(of_this[i]);
      if (tells) unseen[i].sentence.insert(0, camera_prefix(experiment_, k));
    }
  }
  return unseen;
}

std::vector<std::string> Cameras::alarms() {
  std::vector<std::string> all;
  for (Each& camera : all_)
    for (std::string& sentence : camera.rig->alarms()) all.push_back(std::move(sentence));
  const std::lock_guard lock(mutex_);
  for (std::string& sentence : std::exchange(alarms_, {})) all.push_back(std::move(sentence));
  return all;
}

MarksStatus Cameras::marks() const {
  MarksStatus all;
  for (const Each& camera : all_) {
    const MarksStatus one = camera.rig->marks();
    all.watched = all.watched || one.watched;
    // The start does not wait for one that is lost: the others' robots can drive without it.
    all.known = all.known && (one.known || camera.lost.load(std::memory_order_acquire));
    if (!all.moved) all.moved = one.moved;
    if (all.exchanged.empty()) all.exchanged = one.exchanged;
    if (!one.sentence.empty()) all.sentence += (all.sentence.empty() ? "" : "; ") + one.sentence;
  }
  return all;
}

std::int64_t Cameras::fewest_frames() const {
  std::int64_t fewest = std::numeric_limits<std::int64_t>::max();
  for (const Each& camera : all_)
    if (!camera.lost.load(std::memory_order_acquire)) fewest = std::min(fewest, camera.rig->frames());
  return fewest;
}

void Cameras::watch() {
  for (std::size_t k = 0; all_.size() > 1 && k < all_.size(); ++k) {
    Each& camera = all_[k];
    const bool failed = camera.rig->failed();
    const vision::SourceStatus status = failed ? vision::SourceStatus{} : camera.rig->camera();
    const bool lost = failed || !status.up;
    if (lost == camera.lost.load(std::memory_order_relaxed)) continue;
    camera.lost.store(lost, std::memory_order_release);
    const std::string prefix = camera_prefix(experiment_, k);
    const std::lock_guard lock(mutex_);
    alarms_.push_back(lost ? fmt::format("{}lost: {}; robots that no other camera sees stand", prefix,
                                         failed ? camera.rig->reason() : status.reason)
                           : prefix + "delivers frames again");
  }
}

bool Cameras::partly_down() const {
  const auto is_lost = [](const Each& camera) { return camera.lost.load(std::memory_order_acquire); };
  return std::any_of(all_.begin(), all_.end(), is_lost) && !std::all_of(all_.begin(), all_.end(), is_lost);
}

std::string Cameras::failure() const {
  std::string reasons;
  for (std::size_t k = 0; k < all_.size(); ++k) {
    if (!all_[k].rig->failed()) return {};
    reasons += (k == 0 ? "" : "; ") + camera_prefix(experiment_, k) + all_[k].rig->reason();
  }
  return reasons;
}

}  // namespace skein::app
