#pragma once

#include <string>
#include <vector>

#include "vision/calibration/board_view.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/frame.h"
#include "vision/modules/page.h"
#include "vision/tags/detection.h"

// The parts that need OpenCV's calibration and ArUco, or cairo: calibration boards, printed sheets, and ArUco as a
// benchmark. A module of its own, so that the program loads these libraries only when it needs them.

namespace skein::vision {

/// A known point and where it was seen.
struct Landmark {
  double x, y, z;  // in the world [m]
  double u, v;     // [px]
};

/// Returned texts: empty, or the error.
struct Boards {
  /// The tags of DICT_APRILTAG_36h11, their corners refined to parts of a pixel (CORNER_REFINE_SUBPIX, window 3), on
  /// one thread.
  void (*detect)(const Frame& frame, std::vector<Detection>& found);

  /// ArUco's markers of `bits` by `bits` cells (4 to 7) without a wrong cell; `tag` is the number in the dictionary of
  /// 1,000. On one thread.
  void (*detect_aruco)(const Frame& frame, int bits, std::vector<Detection>& found);

  /// See find_board.
  void (*find)(const Frame& frame, const Board& board, std::vector<BoardCorner>& corners);

  /// OpenCV's calibrateCamera: calibration, sigmas, tilt, spread and scatter of `result`, and the residual of every
  /// corner [px].
  std::string (*calibrate)(const std::vector<BoardView*>& views, int width, int height, Intrinsics& result,
                           std::vector<std::vector<double>>& residuals);

  /// OpenCV's solvePnP: the world frame of a calibration whose intrinsics are known.
  std::string (*locate)(const std::vector<Landmark>& landmarks, Calibration& calibration);

  /// The cells of a marker with its border, (bits + 2) squared, row by row; true: ink.
  std::vector<bool> (*marker)(int bits, int id);

  std::string (*draw)(const std::vector<Page>& pages, bool pdf, std::string& file);
  std::string (*rasterise)(const Page& page, double px_per_mm, Frame& frame);
};

/// Carries a number for the same reason as media_symbol.
inline constexpr const char* boards_symbol = "skein_boards_6";

}  // namespace skein::vision
