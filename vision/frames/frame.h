#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "vision/frames/large_pages.h"

namespace skein::vision {

/// One grey picture. Pixel (u, v) is column u to the right, row v down, (0, 0) at the CENTRE of the top-left pixel.
/// A source fills the same Frame again and again: its buffers grow once and are then reused.
struct Frame {
  using Grey = std::vector<std::uint8_t, LargePages<std::uint8_t>>;

  int width = 0;             // px
  int height = 0;            // px
  Grey grey;                 // row by row, width * height bytes, no padding; 0 black, 255 white
  double captured_at = 0.0;  // s, its first row: CLOCK_MONOTONIC for a camera, time in the film for a video
  double arrived_at = 0.0;   // s, CLOCK_MONOTONIC: when a camera's driver handed it over; 0: not known
  std::string source;        // file name of a picture, number of the frame in a stream
  std::int64_t index = 0;    // counts the frames of its source from 0
  std::string note;          // a line that a film stores and returns with it; usually empty

  /// Makes room for width x height pixels; their values are unspecified.
  void resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    grey.resize(static_cast<std::size_t>(new_width) * static_cast<std::size_t>(new_height));
  }
  const std::uint8_t* row(int v) const { return grey.data() + static_cast<std::ptrdiff_t>(v) * width; }
  std::uint8_t* row(int v) { return grey.data() + static_cast<std::ptrdiff_t>(v) * width; }
};

}  // namespace skein::vision
