#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/run/tick_record.h"
#include "vision/tags/tag_family.h"

namespace skein::app {

/// A tag on the floor at a measured position.
struct FloorTag {
  static constexpr int largest_id = vision::largest_tag;
  int id = 0;                         ///< of the family 36h11
  double x = 0.0, y = 0.0, z = 0.0;   ///< its centre, in the world frame; z above the floor [m]
  double off_x = none, off_y = none;  ///< its position by the result minus the measured one; none: not seen [m]
};

/// The pose of a camera, from tags on the floor.
struct FloorSurvey {
  std::vector<FloorTag> tags;
  double rms = 0.0, worst = 0.0;                   ///< of the tags that were seen, without `suspect` [m]
  std::array<double, 3> camera{none, none, none};  ///< the lens's position in the world frame [m]
  std::vector<std::string> unseen{};               ///< why tags were not seen, and where: sentences without a full stop
  std::string suspect{};                           ///< the tag without which the others agree far better; empty: none
  double poses_move = none;  ///< rms over the floor between the tags; none: not calibrated before [m]
};

struct FloorQuestion {
  std::vector<std::string> settings{};        ///< of a camera: "focus=30"
  std::string source;                         ///< v4l2:DEVICE, aravis:CAMERA, images:DIR, video:FILE
  std::string calibration;                    ///< file with the intrinsics; the floor is written into it
  std::vector<FloorTag> tags;                 ///< four and more, not all on one line
  double tag_size = 0.04, tag_height = 0.06;  ///< of the robots' tags [m]
};

/// The tags by which the camera of a calibration file was calibrated, and the robots' tags; none: there is no such
/// file, or it has no such tags.
struct KnownFloor {
  std::vector<FloorTag> tags;
  double tag_size = 0.0, tag_height = 0.0;  ///< [m]
};
std::optional<KnownFloor> known_floor(const std::string& calibration);

/// Observes the floor for about a second, solves, and writes the calibration with its world frame, like `skein
/// calibrate floor`. Blocks; `ends` ends it. The error: a sentence; nothing is written then.
tl::expected<FloorSurvey, std::string> survey_floor(const FloorQuestion& question, const std::atomic<bool>& ends);

}  // namespace skein::app
