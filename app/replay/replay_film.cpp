#include "app/replay/replay_film.h"

#include <fmt/format.h>

#include "app/calibration/calibration_file.h"
#include "app/session/camera_rig.h"
#include "vision/sources/open_source.h"

namespace skein::app {

tl::expected<ReplayFilm, std::string> ReplayFilm::open(const std::string& path, const Experiment& experiment) {
  if (experiment.cameras() > 1)
    return tl::unexpected(
        fmt::format("{}: the run had {} cameras, and a replay from frames takes those of one alone; "
                    "without a film it takes the poses that the cameras measured",
                    path, experiment.cameras()));
  auto source = vision::open_source("video:" + path);
  if (!source) return tl::unexpected(source.error());
  const auto calibration_note = (*source)->notes().find("CALIBRATION");
  if (!(*source)->recorded() || calibration_note == (*source)->notes().end())
    return tl::unexpected(fmt::format(
        "{}: has no capture times and no calibration; allowed: a film recorded by `skein run --video`", path));
  const auto calibration = parse_calibration(calibration_note->second, path + " (CALIBRATION)");
  if (!calibration) return tl::unexpected(calibration.error());
  if (!calibration->world_from_camera)
    return tl::unexpected(fmt::format("{}: its calibration has no world frame", path));
  std::vector<int> wanted = wanted_tags(experiment);
  vision::TagTracker tracker(*calibration, {.tags = wanted});
  return ReplayFilm(std::move(*source), std::move(tracker), std::move(wanted));
}

bool ReplayFilm::lossless() const {
  const auto coding = source_->notes().find(vision::coding_note);
  return coding == source_->notes().end() || coding->second == word(vision::FilmCoding::lossless);
}

tl::expected<void, std::string> ReplayFilm::advance(double time, std::span<core::Measurement> newest) {
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
    update_newest(tracker_.process(next_), wanted_, newest);
    ++frames_;
    has_next_ = false;
  }
  return {};
}

}  // namespace skein::app
