#pragma once

#include <array>
#include <atomic>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/run/tick_record.h"

namespace skein::app {

/// A tag that lies on the floor where somebody has measured it.
struct FloorTag {
  int id = 0;                         ///< of the family 36h11
  double x = 0.0, y = 0.0, z = 0.0;   ///< its middle, in the world; z above the floor [m]
  double off_x = none, off_y = none;  ///< where the result sees it, less where it lies; none: not seen [m]
};

/// Where a camera hangs, from tags on the floor.
struct FloorSurvey {
  std::vector<FloorTag> tags;
  double rms = 0.0, worst = 0.0;                   ///< of the tags that were seen [m]
  std::array<double, 3> camera{none, none, none};  ///< the lens's place in the world [m]
  std::string suspect{};                           ///< the tag without which the others agree far better; empty: none
};

struct FloorQuestion {
  std::vector<std::string> settings{};        ///< of a camera: "focus=30"
  std::string source;                         ///< v4l2:DEVICE, aravis:CAMERA, images:DIR, video:FILE
  std::string calibration;                    ///< file with the intrinsics; the floor is written into it
  std::vector<FloorTag> tags;                 ///< four and more, not all on one line
  double tag_size = 0.04, tag_height = 0.06;  ///< of the robots' tags [m]
};

/// Looks at the floor for a second or so, solves, and writes the calibration with its world frame, as `skein calibrate
/// floor` does. Blocks; `ends` ends it. The error: a sentence; nothing is written then.
tl::expected<FloorSurvey, std::string> survey_floor(const FloorQuestion& question, const std::atomic<bool>& ends);

}  // namespace skein::app
