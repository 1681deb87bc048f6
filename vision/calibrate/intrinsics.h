#pragma once

#include <array>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/board_view.h"
#include "vision/frames/frame.h"

namespace skein::vision {

/// The corners that a frame shows: all of a chessboard or none, of a ChArUco board those that can be identified. The
/// error is that of the module, not that of a frame without a board.
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
  /// Share of the parts that had at least one corner.
  double share() const;
  /// A line for each row: '.' none, '-' fewer than 10, '#' more.
  std::string text() const;
};

/// Focal lengths, principal point and distortion from views of a board (Zhang 2000, by OpenCV). Leaves out corners that
/// are off by more than four times the usual residual of their view, and views whose residual is more than three times
/// that of the median view, then solves again. Needs at least three views of at least 6 corners, from different sides;
/// a result that leaves corners far from where they were seen is an error: the board is not the one described.
tl::expected<Intrinsics, std::string> solve_intrinsics(std::vector<BoardView> views, int width, int height);

/// None, or a warning if fx and fy differ by more than 0.3 % and four of their deviations: cameras have square pixels,
/// so that the board is longer one way than it should be.
std::string uneven_focal_lengths(const Intrinsics& intrinsics);

/// None, or why the focal length is a guess although its deviation is small: between any two views the board is tilted
/// by less than 8 degrees. Such a result is not to be used.
std::string equal_tilts(const Intrinsics& intrinsics);

/// None, or a warning if neighbouring corners are off in the same direction by more than 0.15 px and 1.2 times what
/// each scatters: views that no camera of this model can have of a flat board of these squares.
std::string systematic_residuals(const Intrinsics& intrinsics);

/// Whether a view differs from each of the others by at least `least_px`, in the mean over their common corners.
/// Without this check a film gives the same view a thousand times.
bool is_new_view(const std::vector<BoardView>& views, const BoardView& view, double least_px);

/// `count` views: the first one, then repeatedly the one that is farthest from all those chosen so far.
std::vector<BoardView> most_different(std::vector<BoardView> views, std::size_t count);

}  // namespace skein::vision
