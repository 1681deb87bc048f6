#pragma once

#include <string>
#include <vector>

#include "vision/calibration/board.h"
#include "vision/calibration/calibration.h"

namespace skein::vision {

/// A board as one frame shows it.
struct BoardView {
  std::string source{};  // of the frame: file name or number
  std::vector<BoardCorner> corners{};
  double rms = 0.0;       // distance of the corners from where the result puts them [px]
  int outliers = 0;       // corners that were left out
  bool rejected = false;  // the view as a whole was left out
};

/// A camera's intrinsics, without its place, from views of a board.
struct Intrinsics {
  Calibration calibration{};       // without a world frame
  std::vector<BoardView> views{};  // all views that were given, with the outcome for each
  double rms = 0.0;                // over all corners that were used [px]
  double focal_sigma = 0.0;        // standard deviation of fx and fy, from the residuals [px]
  double centre_sigma = 0.0;       // of cx and cy [px]
  double tilt = 0.0;               // of the view that is tilted most, against the picture's plane [rad]
  double spread = 0.0;             // largest angle between the board's planes in two views [rad]
  double scatter = 0.0;  // of corners beside one another, as an rms like the above: what is not systematic [px]
};

}  // namespace skein::vision
