#pragma once

#include <string>
#include <vector>

#include "vision/detector/detector.h"
#include "vision/frames/frame.h"

namespace skein::vision::detail {

/// Widths of the clear edges along the rows and columns of a part of a frame: from where a slope begins to where it
/// ends, the difference through the steepest slope. What noise could make is left out. `noise`: of a pixel [grey
/// levels]. Appends to `widths` [px].
void edge_widths(const Frame& frame, const Window& part, double noise, std::vector<double>& widths);

/// What to do about edges of this width [px]; without a full stop.
std::string blur_sentence(double edge_width);

}  // namespace skein::vision::detail
