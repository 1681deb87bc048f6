#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "vision/fit/sampling.h"
#include "vision/frames/frame.h"

namespace skein::vision::detail {

/// Finds places where a tag might be, for a few per cent of what a detector costs. The picture is divided into cells of
/// a few pixels; one is busy where many neighbours, a module apart, differ by more than a threshold; a tag is a square
/// of busy cells. Lines and blank squares are not: they are busy along their edges only. The threshold is the caller's,
/// since it must follow the light.
class Gate {
 public:
  struct Place {
    double u = 0.0;  // [px]
    double v = 0.0;
  };

  /// A tag that was found: no place within `apart` of its middle is reported.
  struct Known {
    Place middle;
    double apart = 0.0;  // [px]
  };

  /// edge_px: of a tag's black square, at the least. The places are the same with all instructions.
  Gate(int width, int height, double edge_px, Instructions instructions = best_instructions());

  /// Rows of cells.
  int rows() const { return rows_; }
  /// Edge of the squares that are looked for, in cells.
  int square() const { return square_; }

  /// Prefetches a part of what scan() will read for these rows of cells: [part, part + 1) of `parts`.
  void fetch(const Frame& frame, int first, int last, int part, int parts) const;

  /// Examines the rows of cells [first, last) of the image; the other rows keep their results.
  void scan(const Frame& frame, int first, int last, int threshold);

  /// Middles of the squares of busy cells that begin in the rows [first, last), none of them within `apart` of another
  /// or near one of `known`. Valid until the next call.
  const std::vector<Place>& places(int first, int last, const std::vector<Known>& known, double apart);

 private:
  void count_busy(const Frame& frame, int first, int last, int threshold);

  Instructions instructions_;
  int step_;      // between the two pixels that are compared: about a module [px]
  int row_step_;  // rows that are looked at: all, or every other
  int down_;      // as step_, downwards: to one of these rows
  int columns_;
  int rows_;
  int square_;                        // edge of the squares that are looked for [cells]
  std::vector<std::uint8_t> busy_;    // 0 or 1, row by row
  std::vector<std::uint8_t> across_;  // busy cells of a row's next `square_`
  std::vector<Place> marks_;
  std::vector<Place> places_;
};

}  // namespace skein::vision::detail
