#include "app/session/experiment_cameras.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/calibration/calibration_file.h"
#include "vision/diagnosis/mark_watch.h"
#include "vision/tags/tag_family.h"
#include "vision/tags/tag_plane.h"

namespace skein::app {
namespace {

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

tl::expected<void, std::string> check_calibrations(const Experiment& experiment) {
  if (experiment.camera.kind() == CameraKind::absent) return {};
  std::vector<vision::CameraPose> places;
  for (std::size_t k = 0; k < experiment.cameras(); ++k) {
    const auto calibration = camera_calibration(experiment, k);
    if (!calibration) return tl::unexpected(calibration.error());
    const vision::CameraPose& place = *calibration->world_from_camera;
    const auto same = std::find(places.begin(), places.end(), place);
    if (same != places.end() && experiment.camera.kind() != CameraKind::synthetic)
      return tl::unexpected(fmt::format(
          "{}camera.calibration: {} has the place of camera {} to the last digit, as a copy has, allowed: a "
          "calibration for each camera, since no two hang at one place",
          camera_prefix(experiment, k), experiment.camera_at(k).calibration, same - places.begin() + 1));
    places.push_back(place);
  }
  return {};
}

bool shows_tag(const vision::Calibration& calibration, double x, double y) {
  const auto at = vision::pixel_from_world(calibration, {x, y, calibration.tag_height});
  const double reach = 1.5 * vision::tag_edge_px(calibration);
  return at && at->x() >= reach && at->y() >= reach && at->x() <= calibration.width - 1.0 - reach &&
         at->y() <= calibration.height - 1.0 - reach;
}

namespace {

/// Whether there is a place where both cameras see a whole tag.
bool views_overlap(const vision::Calibration& one, const vision::Calibration& other) {
  constexpr int steps = 24;  // across the picture, and down
  for (int row = 0; row <= steps; ++row)
    for (int column = 0; column <= steps; ++column) {
      const double u = (one.width - 1.0) * column / steps, v = (one.height - 1.0) * row / steps;
      const auto place = vision::world_from_pixel(one, {u, v}, one.tag_height);
      if (place && shows_tag(one, place->x(), place->y()) && shows_tag(other, place->x(), place->y())) return true;
    }
  return false;
}

}  // namespace

std::vector<UnguardedCalibration> unguarded_calibrations(const Experiment& experiment) {
  if (experiment.cameras() < 2 || experiment.camera.kind() == CameraKind::synthetic) return {};
  std::vector<vision::Calibration> all;
  for (std::size_t k = 0; k < experiment.cameras(); ++k) {
    auto calibration = camera_calibration(experiment, k);
    if (!calibration) return {};  // check_calibrations says why
    all.push_back(std::move(*calibration));
  }
  std::vector<UnguardedCalibration> unguarded;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (vision::MarkWatch(all[k], wanted_tags(experiment)).marks() >= vision::MarkWatch::least_seen) continue;
    bool overlaps = false;
    for (std::size_t j = 0; j < all.size(); ++j) overlaps = overlaps || (j != k && views_overlap(all[k], all[j]));
    unguarded.push_back({k, fmt::format("{}{} has no marks on the floor{}nothing shows that it is this camera's",
                                        camera_prefix(experiment, k), experiment.camera_at(k).calibration,
                                        overlaps ? ": until another camera sees the same robot as this one, "
                                                 : ", and this view overlaps with no other camera's: ")});
  }
  return unguarded;
}

std::vector<std::string> uneven_focal_lengths(const Experiment& experiment) {
  constexpr double most = 0.01;  // of the smaller one; skein calibrate intrinsics speaks of a third of this
  std::vector<std::string> sentences;
  for (std::size_t k = 0; k < experiment.cameras() && experiment.camera.kind() != CameraKind::absent; ++k) {
    const auto of = camera_calibration(experiment, k);
    const double apart = of ? std::abs(of->fx - of->fy) / std::min(of->fx, of->fy) : 0.0;
    if (apart <= most) continue;
    sentences.push_back(
        fmt::format("{}fx and fy of {} differ by {:.1f} %, but cameras have square pixels: skein calibrate intrinsics "
                    "measures them",
                    camera_prefix(experiment, k), experiment.camera_at(k).calibration, 100.0 * apart));
  }
  return sentences;
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

}  // namespace skein::app
