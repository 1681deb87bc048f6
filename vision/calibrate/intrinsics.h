#pragma once

#include <array>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/board_view.h"
#include "vision/frames/frame.h"

namespace skein::vision {

/// The corners that a frame shows: all of a chessboard or none, of a ChArUco board those that can be told. The error is
/// that of the module, not that of a frame without a board.
tl::expected<std::vector<BoardCorner>, std::string> find_board(const Frame& frame, const Board& board);

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

/// Focal lengths, principal point and distortion from views of a board (Zhang 2000, by OpenCV). Corners more than four
/// times the residual off, and views whose residual is more than three times the usual one, are left out, and the rest
/// is solved again. Needs three views of 6 corners and more, from different sides; a result that leaves corners far
/// from where they were seen is an error: the board is another one.
tl::expected<Intrinsics, std::string> solve_intrinsics(std::vector<BoardView> views, int width, int height);

/// None, or a warning if fx and fy differ by more than 0.3 % and four of their deviations: cameras have square pixels,
/// so that the board is longer one way than it should be.
std::string uneven_focal_lengths(const Intrinsics& intrinsics);

/// True where a view shows the board elsewhere or otherwise than all the others, by `least_px` in the mean of the
/// corners that both have. A film would else give a thousand times the same view.
bool is_new_view(const std::vector<BoardView>& views, const BoardView& view, double least_px);

/// The first view, and again and again the one that is farthest from all that were chosen, `count` in sum.
std::vector<BoardView> most_different(std::vector<BoardView> views, std::size_t count);

}  // namespace skein::vision
