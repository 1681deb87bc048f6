#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "core/geometry/pose.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/frame.h"

namespace skein::vision {

/// A tag to be seen, on its robot. The tag's x axis, from its left edge to its right as printed upright, points along
/// the robot's heading: theta = 0 shows the tag upright in a picture whose u runs along the world's x.
struct SyntheticTag {
  int tag = 0;                     // id in the family 36h11, 0..586; another id is drawn as blank paper
  core::Pose pose;                 // centre of the tag in the world [m, rad]
  double size = default_tag_size;  // edge of the black square [m]; the paper is 10/8 of it
  double lifted = 0.0;             // height above tag_height at which it is held [m]
  double smear = 0.0;  // how far it drives ahead while the shutter is open; `pose` is where it is halfway [m]
  bool bare = false;   // nothing carries it: neither body nor shadow below it
};

/// A thing above the tags: an arm, a lamp's reflection.
struct SyntheticDisc {
  double x = 0.0;  // [m]
  double y = 0.0;
  double radius = 0.05;  // [m]
  double height = 0.15;  // above the floor [m]
  double grey = 110.0;   // in full light
  double soft = 0.0;     // width of its edge, over which the cover falls from full to nothing [m]
  double cover = 1.0;    // share of what is below that it hides (0..1): a shadow has grey 0 and hides a part
};

struct SceneOptions {
  double noise_sigma = 4.0;      // of the sensor, Gaussian [grey levels of 255]
  double blur_px = 0.7;          // standard deviation of the lens's blur [px]
  double brightness = 1.0;       // of the light; 1: white paper is at 225 of 255 where the light is best
  double light_gradient = 0.25;  // part of the light lost from the best-lit corner of the picture to the opposite one
  double contrast = 1.0;         // of the print; 1: ink is at 30 where paper is at 225; 0: both at 225
  double flicker = 0.0;          // of the lamps: (most - least) / (most + least) of their light, 0..1; a sine
  double flicker_hz = 100.0;     // twice the mains'
  double exposure = 0.001;       // how long a row collects light, from its capture time on [s]
  int clutter = 60;              // pieces of tape, marks and dirt on the floor
  double body_radius = 0.035;    // of the robot under the tag [m]; 0: none
};

/// Pictures of tags on a textured floor as the calibration's camera would see them: true perspective and distortion at
/// tag_height, area-sampled edges, blur, uneven light, sensor noise. The same seed and the same calls give the same
/// bytes.
class SyntheticCamera {
 public:
  /// The calibration must have a world frame (std::invalid_argument: that is the caller's mistake).
  explicit SyntheticCamera(Calibration calibration, const SceneOptions& options = {}, std::uint64_t seed = 1);
  ~SyntheticCamera();
  SyntheticCamera(SyntheticCamera&&) noexcept;
  SyntheticCamera& operator=(SyntheticCamera&&) noexcept;

  /// Moves the camera to another pose. Only what `render` draws moves; the floor's texture stays where it was painted.
  void hang(const CameraPose& pose);

  /// Sets the lens's blur from now on [px].
  void focus(double blur_px);

  /// Tags and parts of tags outside the picture are not drawn; a later tag covers an earlier one.
  void render(std::span<const SyntheticTag> tags, double captured_at, Frame& out) {
    render(tags, {}, captured_at, out);
  }
  /// The same with discs over them, in their order.
  void render(std::span<const SyntheticTag> tags, std::span<const SyntheticDisc> discs, double captured_at, Frame& out);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace skein::vision
