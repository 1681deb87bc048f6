#pragma once

#include "vision/frames/frame.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_pattern.h"

namespace skein::vision::detail {

/// How much the square between these corners, with the white border around it as far as it is in the frame, looks like
/// this tag: the normalised correlation with its pattern as a camera in focus would show it, -1..1. Decoding looks at
/// the sign of 36 bits, so that texture may pass for a tag there; here it reaches a half at most, a tag 0.85 and more.
double likeness(const Frame& frame, const Corners& corners, const TagPattern& pattern);

/// The mean size of the modules of a square. [px]
double module_px(const Corners& corners);

}  // namespace skein::vision::detail
