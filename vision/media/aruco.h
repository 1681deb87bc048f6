#pragma once

#include <vector>

#include "vision/detector.h"
#include "vision/frame.h"

// OpenCV's ArUco, only to be measured against: a module of its own, so that no start of the program pays for it.

namespace skein::vision {

struct Aruco {
  /// The tags of DICT_APRILTAG_36h11, their corners refined to parts of a pixel (CORNER_REFINE_SUBPIX, window 3), on
  /// one thread.
  void (*detect)(const Frame& frame, std::vector<Detection>& found);
};

/// Carries a number for the same reason as media_symbol.
inline constexpr const char* aruco_symbol = "skein_aruco_1";

}  // namespace skein::vision
