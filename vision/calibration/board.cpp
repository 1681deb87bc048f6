#include "vision/calibration/board.h"

#include <fmt/format.h>

namespace skein::vision {

std::string check(const Board& board) {
  if (board.columns < 3 || board.rows < 3 || board.columns > 100 || board.rows > 100)
    return fmt::format("a board of {}x{} squares; allowed: 3x3 to 100x100", board.columns, board.rows);
  if (!(board.square >= 1e-3 && board.square <= 1.0))
    return fmt::format("squares of {} m; allowed: 0.001 to 1 m", board.square);
  if (!board.has_markers()) return {};
  if (!(board.marker > 0.3 * board.square && board.marker <= 0.9 * board.square))
    return fmt::format("markers of {} m in squares of {} m; allowed: 0.3 to 0.9 of a square", board.marker,
                       board.square);
  if (board.bits < 4 || board.bits > 7) return fmt::format("markers of {} bits; allowed: 4 to 7", board.bits);
  if (board.columns * board.rows / 2 > 1000) return "more markers than the 1000 there are";
  return {};
}

}  // namespace skein::vision
