#include "app/session/camera_film.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "vision/sources/open_source.h"

namespace skein::app {

tl::expected<CameraFilm, std::string> open_film(const std::string& path) {
  auto source = vision::open_source("video:" + path);
  if (!source) return tl::unexpected(source.error());
  const auto note = (*source)->notes().find("CALIBRATION");
  if (!(*source)->recorded() || note == (*source)->notes().end())
    return tl::unexpected(fmt::format(
        "{}: has no capture times and no calibration; allowed: a film recorded by `skein run --video`", path));
  auto calibration = parse_calibration(note->second, path + " (CALIBRATION)");
  if (!calibration) return tl::unexpected(calibration.error());
  if (!calibration->world_from_camera)
    return tl::unexpected(fmt::format("{}: its calibration has no world frame", path));
  return CameraFilm{std::move(*source), std::move(*calibration)};
}

std::string note_of(std::span<const vision::SeenElsewhere> elsewhere) {
  std::string note;
  for (const vision::SeenElsewhere& seen : elsewhere)
    note += fmt::format("{}{} {} {} {}", note.empty() ? "" : " ", seen.tag, seen.pose.x, seen.pose.y, seen.pose.theta);
  return note;
}

std::vector<vision::SeenElsewhere> elsewhere_of(const std::string& note) {
  std::vector<vision::SeenElsewhere> elsewhere;
  const char* at = note.data();
  const char* const end = at + note.size();
  const auto number = [&](auto& value) {
    while (at != end && *at == ' ') ++at;
    const auto [behind, error] = std::from_chars(at, end, value);
    at = behind;
    return error == std::errc{};
  };
  for (vision::SeenElsewhere seen;
       number(seen.tag) && number(seen.pose.x) && number(seen.pose.y) && number(seen.pose.theta);)
    elsewhere.push_back(seen);
  return elsewhere;
}

std::vector<std::string> film_paths(const Experiment& experiment, const std::string& path) {
  std::vector<std::string> paths{path};
  const std::filesystem::path whole(path);
  for (std::size_t k = 2; k <= experiment.cameras(); ++k)
    paths.push_back(
        (whole.parent_path() / fmt::format("{}-{}{}", whole.stem().string(), k, whole.extension().string())).string());
  return paths;
}

}  // namespace skein::app
