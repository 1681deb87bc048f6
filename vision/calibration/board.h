#pragma once

#include <string>

namespace skein::vision {

/// A flat calibration board, as it is printed.
struct Board {
  enum class Kind { charuco, chessboard };
  Kind kind = Kind::charuco;
  int columns = 12;       // of squares, black and white; a chessboard has columns - 1 inner corners in a row
  int rows = 8;           // of squares
  double square = 0.020;  // edge of a square [m]
  double marker = 0.015;  // ChArUco: edge of a marker's black square [m]
  int bits = 5;           // ChArUco: markers of bits x bits, from OpenCV's DICT_nXn_1000 (4 to 7)

  bool has_markers() const noexcept {
    switch (kind) {
      case Kind::charuco:
        return true;
      case Kind::chessboard:
        return false;
    }
    return false;
  }
  int inner_corners() const { return (columns - 1) * (rows - 1); }
};

/// Empty, or its error.
std::string check(const Board& board);

/// A corner of the board in one frame.
struct BoardCorner {
  int id = 0;      // row by row, from 0
  double x = 0.0;  // on the board [m], x along its rows, y down its columns
  double y = 0.0;
  double u = 0.0;  // in the frame [px]
  double v = 0.0;
};

}  // namespace skein::vision
