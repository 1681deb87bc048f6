#pragma once

#include <cstdint>
#include <optional>

#include "vision/frames/frame.h"

namespace skein::vision {

/// The grey level at a point between pixels: the mean of the four around it, weighted by how near they are (bilinear).
/// u to the right, v down, (0, 0) is the middle of the first pixel. [px]; none: it is not between four pixels.
inline std::optional<double> grey_at(const Frame& frame, double u, double v) noexcept {
  if (!(u >= 0.0 && v >= 0.0 && u < frame.width - 1.0 && v < frame.height - 1.0)) return {};
  const int column = static_cast<int>(u), row = static_cast<int>(v);
  const double right = u - column, down = v - row;
  const std::uint8_t* const above = frame.row(row) + column;
  const std::uint8_t* const below = frame.row(row + 1) + column;
  return (1.0 - down) * ((1.0 - right) * above[0] + right * above[1]) +
         down * ((1.0 - right) * below[0] + right * below[1]);
}

}  // namespace skein::vision
