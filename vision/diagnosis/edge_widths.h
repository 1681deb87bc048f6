#pragma once

#include <span>
#include <string>
#include <vector>

#include "vision/detector/detector.h"
#include "vision/frames/frame.h"

namespace skein::vision::detail {

/// Widths of the clear edges along the rows and columns of a part of a frame: from where a slope begins to where it
/// ends, the difference through the steepest slope. What noise could make is left out. `noise`: of a pixel [grey
/// levels]. Appends to `widths` [px].
void edge_widths(const Frame& frame, const Window& part, double noise, std::vector<double>& widths);

/// What people read of such widths, one of each frame: "4.1", of several frames "4.1 to 5.0".
std::string range_of(std::span<const double> edge_widths);
/// What to do about edges of these widths [px], one of each frame; without a full stop.
std::string blur_sentence(std::span<const double> edge_widths);

}  // namespace skein::vision::detail
