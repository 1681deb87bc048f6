#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/session/simulated_world.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/frame.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {

/// The camera of a simulation: it renders the floor with its robots and marks, and does for practice what `[camera]` in
/// the experiment asks for: it is bumped, loses its focus, freezes, is lost. One thread at a time.
class RenderedCamera {
 public:
  /// All of these must outlive it. `seed`: of its noise and light.
  RenderedCamera(const Experiment& experiment, const CameraSpec& spec, const vision::Calibration& calibration,
                 std::uint64_t seed, SimulatedWorld& world);

  bool is_lost(double now) const { return spec_.lost_at && now >= *spec_.lost_at; }
  /// The picture whose last row is read at `now`. [s, session's clock]
  void render(double now, vision::Frame& frame);

 private:
  void place_robots(double stamp, double now);
  void place_marks(double now);
  void bump(double now);
  void defocus(double now);
  void freeze(double now, vision::Frame& frame);

  const Experiment& experiment_;
  const CameraSpec& spec_;
  const vision::Calibration& calibration_;
  SimulatedWorld& world_;
  vision::SyntheticCamera camera_;
  double bumped_ = 0.0;                           // the share of its bump that it has had
  double blur_ = vision::SceneOptions{}.blur_px;  // likewise
  std::vector<core::Pose> poses_, row_poses_;
  std::vector<vision::SyntheticTag> tags_;
  std::array<vision::Frame::Grey, 4> stills_;  // the pictures that are repeated
  std::size_t rendered_ = 0;
};

}  // namespace skein::app
