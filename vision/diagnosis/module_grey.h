#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "vision/frames/frame.h"
#include "vision/tags/detection.h"

namespace skein::vision::detail {

/// The pixel of a tag at a place in modules from its top left corner; its border is outside 0 to 8. A straight map from
/// corner to corner will do, and what is outside the frame is taken from its edge. [grey levels]
inline double module_grey(const Frame& frame, const Corners& corners, double column, double row) {
  const double s = column / 8.0, t = row / 8.0;
  const std::array<double, 4> weights{(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t};
  double u = 0.0, v = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    u += weights[i] * corners[i][0];
    v += weights[i] * corners[i][1];
  }
  const int column_px = std::clamp(static_cast<int>(std::lround(u)), 0, frame.width - 1);
  const int row_px = std::clamp(static_cast<int>(std::lround(v)), 0, frame.height - 1);
  return static_cast<double>(frame.row(row_px)[column_px]);
}

}  // namespace skein::vision::detail
