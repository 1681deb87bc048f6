#include "app/tools/joint_films.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/session/camera_film.h"
#include "app/session/experiment_cameras.h"
#include "vision/detector/detector.h"
#include "vision/tags/tag_plane.h"

namespace skein::app {
namespace {

/// The robots' tags that lie flat where the calibration has them.
void add_sights(const std::vector<vision::Detection>& found, const std::vector<int>& wanted,
                const vision::Calibration& calibration, double captured_at, std::vector<vision::TagPose>& sights) {
  constexpr double size_tolerance = 0.1;  // of a calibration that is off
  for (const vision::Detection& tag : found) {
    const auto same = [&](const vision::Detection& other) { return other.tag == tag.tag; };
    if (std::find(wanted.begin(), wanted.end(), tag.tag) == wanted.end() ||
        std::count_if(found.begin(), found.end(), same) != 1)
      continue;
    const auto square = vision::place_on_plane(calibration, tag.corners);
    if (!square || std::abs(square->edge / calibration.tag_size - 1.0) > size_tolerance) continue;
    double row = 0.0;
    for (const auto& corner : tag.corners) row += 0.25 * corner[1];
    sights.push_back({.tag = tag.tag, .pose = square->pose, .captured_at = captured_at + calibration.row_time * row});
  }
}

}  // namespace

tl::expected<JointFilms, std::string> joint_films(const Experiment& experiment, const std::string& film,
                                                  std::size_t reference, const JointProgress& keep_on) {
  JointFilms result;
  const std::size_t cameras = experiment.cameras();
  for (std::size_t k = 0; k < cameras; ++k) result.files.push_back(experiment.calibration_file(k));
  std::vector<vision::Calibration> calibrations;
  std::vector<std::vector<vision::TagPose>> sights(cameras);
  const std::vector<std::string> films = film_paths(experiment, film);
  const std::vector<int> wanted = wanted_tags(experiment);
  vision::TagDetector detector;
  vision::Frame frame;
  for (std::size_t k = 0; k < cameras; ++k) {
    auto opened = open_film(films[k]);
    if (!opened) return tl::unexpected(camera_prefix(experiment, k) + opened.error());
    const auto calibration = camera_calibration(experiment, k);
    if (!calibration) return tl::unexpected(calibration.error());
    if (*calibration != opened->calibration)
      return tl::unexpected(fmt::format(
          "{}{} was recorded with another calibration than {} is now; needed: a film recorded with this one",
          camera_prefix(experiment, k), films[k],
          result.files[k].empty() ? "that of the experiment" : result.files[k]));
    detector.set_decimate(vision::decimate_for_edge(vision::tag_edge_px(*calibration)));
    std::int64_t frames = 0;
    while (true) {
      if (keep_on && !keep_on(k, frames)) return tl::unexpected(std::string("interrupted"));
      const auto more = opened->source->read(frame);
      if (!more) return tl::unexpected(camera_prefix(experiment, k) + more.error());
      if (!*more) break;
      ++frames;
      add_sights(detector.detect(frame), wanted, *calibration, frame.captured_at, sights[k]);
    }
    for (const std::string& skipped : opened->source->skipped())
      result.skipped.push_back(camera_prefix(experiment, k) + skipped);
    result.frames.push_back(frames);
    result.sights.push_back(sights[k].size());
    calibrations.push_back(*calibration);
  }
  auto joint = vision::solve_joint(calibrations, sights, reference);
  if (!joint) return tl::unexpected(joint.error());
  result.joint = std::move(*joint);
  return result;
}

}  // namespace skein::app
