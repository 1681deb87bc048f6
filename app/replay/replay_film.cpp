#include "app/replay/replay_film.h"

#include <algorithm>
#include <cmath>

#include "app/session/experiment_cameras.h"

namespace skein::app {

namespace {

/// When the newest frame of a camera that a tick knew of was taken; a frame in which no robot was seen may be unknown.
double newest_capture(std::span<const core::Measurement> by_camera) noexcept {
  double newest = core::Measurement::never;
  for (const core::Measurement& seen : by_camera) newest = std::fmax(newest, seen.captured_at);
  return newest;
}

}  // namespace

tl::expected<ReplayFilm, std::string> ReplayFilm::open(const std::string& path, const Experiment& experiment) {
  auto film = open_film(path);
  if (!film) return tl::unexpected(film.error());
  std::vector<int> wanted = wanted_tags(experiment);
  vision::TagTracker tracker(film->calibration, {.tags = wanted});
  return ReplayFilm(std::move(film->source), std::move(tracker), std::move(wanted));
}

std::string ReplayFilm::experiment() const {
  const auto text = source_->notes().find("EXPERIMENT");
  return text == source_->notes().end() ? std::string() : text->second;
}

bool ReplayFilm::lossless() const {
  const auto coding = source_->notes().find(vision::coding_note);
  return coding == source_->notes().end() || coding->second == word(vision::FilmCoding::lossless);
}

tl::expected<void, std::string> ReplayFilm::advance(std::span<const core::Measurement> recorded,
                                                    std::span<core::Measurement> newest) {
  const double time = newest_capture(recorded);
  while (!ended_) {
    if (!has_next_) {
      const auto read = source_->read(next_);
      if (!read) return tl::unexpected(read.error());
      ended_ = !*read;
      has_next_ = *read;
      if (ended_) break;
    }
    if (next_.captured_at > time) break;
    missing_ += next_.index - last_index_ - 1;
    last_index_ = next_.index;
    last_at_ = next_.captured_at;
    if (next_.note != repeated_note) update_newest(tracker_.process(next_, elsewhere_of(next_.note)), wanted_, newest);
    ++frames_;
    has_next_ = false;
  }
  if (ended_ && frames_ > 0) short_by_ = std::max(short_by_, time - last_at_);
  // The frame of the recorded measurement is missing if the film ends, or has a gap, before it.
  const bool gap_follows = ended_ || next_.index > last_index_ + 1;
  if (missing_ > 0 || (gap_follows && newest_capture(newest) < time)) exact_ = false;
  return {};
}

}  // namespace skein::app
