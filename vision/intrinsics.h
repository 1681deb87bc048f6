#pragma once

#include <array>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/board.h"
#include "vision/calibration.h"

namespace skein::vision {

/// A board as one frame shows it.
struct BoardView {
  std::string source{};  // of the frame: file name or number
  std::vector<BoardCorner> corners{};
  double rms = 0.0;       // distance of the corners from where the result puts them [px]
  int outliers = 0;       // corners that were left out
  bool rejected = false;  // the view as a whole was left out
};

/// Which parts of the picture the corners of all views have been in.
struct Coverage {
  static constexpr int columns = 10;
  static constexpr int rows = 8;
  int width = 0;
  int height = 0;
  std::array<int, columns * rows> corners{};  // row by row

  Coverage(int picture_width, int picture_height) : width(picture_width), height(picture_height) {}
  void add(const BoardView& view);
  /// Share of the parts that had any.
  double share() const;
  /// A line for each row: '.' none, '-' fewer than 10, '#' more.
  std::string text() const;
};

struct Intrinsics {
  Calibration calibration{};       // without a world frame
  std::vector<BoardView> views{};  // those that went in, with what became of them
  double rms = 0.0;                // over all corners that were used [px]
  double focal_sigma = 0.0;        // standard deviation of fx and fy, from the residuals [px]
  double centre_sigma = 0.0;       // of cx and cy [px]
};

/// Focal lengths, principal point and distortion from views of a board (Zhang 2000, by OpenCV). Corners more than four
/// times the residual off, and views whose residual is more than three times the usual one, are left out, and the rest
/// is solved again. Needs three views of 6 corners and more, from different sides; a result that leaves corners far
/// from where they were seen is an error: the board is another one.
tl::expected<Intrinsics, std::string> solve_intrinsics(std::vector<BoardView> views, int width, int height);

/// True where a view shows the board elsewhere or otherwise than all the others, by `least_px` in the mean of the
/// corners that both have. A film would else give a thousand times the same view.
bool is_new_view(const std::vector<BoardView>& views, const BoardView& view, double least_px);

/// The first view, and again and again the one that is farthest from all that were chosen, `count` in sum.
std::vector<BoardView> most_different(std::vector<BoardView> views, std::size_t count);

}  // namespace skein::vision
