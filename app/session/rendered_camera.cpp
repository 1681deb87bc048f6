#include "app/session/rendered_camera.h"

#include <algorithm>
#include <cmath>

namespace skein::app {

RenderedCamera::RenderedCamera(const Experiment& experiment, const CameraSpec& spec,
                               const vision::Calibration& calibration, std::uint64_t seed, SimulatedWorld& world)
    : experiment_(experiment),
      spec_(spec),
      calibration_(calibration),
      world_(world),
      camera_(calibration, vision::SceneOptions{}, seed),
      poses_(experiment.robots.size()),
      row_poses_(experiment.robots.size()) {
  if (calibration.row_time > 0.0) world.remember_for(calibration.readout() + spec.stamps_late);
}

void RenderedCamera::render(double now, vision::Frame& frame) {
  world_.advance(now);
  // A rolling shutter's frame is there when its last row has been read; its stamp is of the first one.
  const double stamp = now - calibration_.readout();
  tags_.clear();
  place_marks(now);
  place_robots(stamp, now);
  bump(now);
  defocus(now);
  camera_.render(tags_, stamp, frame);
  freeze(now, frame);
}

/// Each robot is drawn where it was when the row of its tag was read. Where it is in the picture tells the row.
void RenderedCamera::place_robots(double stamp, double now) {
  const double first_row = stamp - spec_.stamps_late;
  if (first_row < now)
    world_.poses_at(first_row, poses_);
  else
    world_.poses(poses_);
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    if (calibration_.row_time <= 0.0) break;
    const auto at = vision::pixel_from_world(calibration_, {poses_[i].x, poses_[i].y, calibration_.tag_height});
    if (!at || std::isnan(at->y())) continue;
    world_.poses_at(first_row + calibration_.row_time * std::clamp(at->y(), 0.0, double(calibration_.height)),
                    row_poses_);
    poses_[i] = row_poses_[i];
  }
  for (std::size_t i = 0; i < poses_.size(); ++i)
    if (!std::isnan(poses_[i].x)) tags_.push_back({experiment_.robots[i].tag, poses_[i], calibration_.tag_size});
}

void RenderedCamera::place_marks(double now) {
  constexpr double moved_by = 0.05;  // the first one, for practice [m]
  for (const vision::FloorMark& mark : calibration_.marks) {
    if (mark.tag < 0) continue;
    const bool moved = tags_.empty() && spec_.mark_moved_at && now >= *spec_.mark_moved_at;
    tags_.push_back({.tag = mark.tag,
                     .pose = {mark.x + (moved ? moved_by : 0.0), mark.y, 0.0},
                     .size = mark.size > 0.0 ? mark.size : calibration_.tag_size,
                     .lifted = mark.z - calibration_.tag_height,
                     .bare = true});
  }
}

void RenderedCamera::bump(double now) {
  if (!spec_.bump_at || now < *spec_.bump_at) return;
  const double since = now - *spec_.bump_at;
  const double share = since < spec_.bump_time ? since / spec_.bump_time : 1.0;
  if (share != bumped_) {
    vision::CameraPose pose = *vision::tilted(calibration_, share * spec_.bump).world_from_camera;
    pose.position.z() += share * spec_.raise;
    camera_.hang(pose);
  }
  bumped_ = share;
}

void RenderedCamera::defocus(double now) {
  if (!spec_.defocus_at || now < *spec_.defocus_at) return;
  constexpr double step = 0.05;  // the whole floor is blurred anew at each [px]
  const double since = now - *spec_.defocus_at;
  const double sharp = vision::SceneOptions{}.blur_px;
  const double share = since < spec_.defocus_time ? since / spec_.defocus_time : 1.0;
  const double blur = sharp + step * std::floor(share * (spec_.defocus - sharp) / step);
  if (blur != blur_) camera_.focus(blur);
  blur_ = blur;
}

/// The whole picture stands still; a part of it is what a driver with four buffers has in each of them from before, if
/// its transfers break off.
void RenderedCamera::freeze(double now, vision::Frame& frame) {
  if (!spec_.freeze_at) return;
  vision::Frame::Grey& still = stills_[spec_.freeze_part < 1.0 ? rendered_++ % stills_.size() : 0];
  const bool frozen = now >= *spec_.freeze_at && !(spec_.freeze_for && now >= *spec_.freeze_at + *spec_.freeze_for);
  if (!frozen || still.empty()) {
    still = frame.grey;
    return;
  }
  const auto from = static_cast<std::ptrdiff_t>(static_cast<double>(still.size()) * (1.0 - spec_.freeze_part));
  std::copy(still.begin() + from, still.end(), frame.grey.begin() + from);
}

}  // namespace skein::app
