#pragma once

#include <cstdint>

#include "vision/calibration/calibration.h"
#include "vision/synthetic/painter.h"

namespace skein::vision::detail {

/// The floor of a robotics lab seen by the painter's camera: mottled linoleum with seams, and on it pieces of tape,
/// black and white marks (which a tag detector has to look at and refuse), cables and dirt.
void paint_floor(Painter& painter, const Calibration& calibration, int clutter, std::uint64_t seed, Canvas& canvas);

}  // namespace skein::vision::detail
