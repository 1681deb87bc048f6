#pragma once

namespace skein::vision::detail {

/// Below this the photometric fit has too little to go by. [grey levels]
inline constexpr double least_contrast = 12.0;

/// Ink and paper may differ by as little as this where tags are searched for that the tracker does not see. [grey
/// levels]
inline constexpr int faint = 2;

/// Share of a frame's pixels at 250 and more from which on it counts as too bright, and the grey level that 99 % of a
/// dark frame keep below.
inline constexpr double saturated_share = 0.25;
inline constexpr int dark_grey = 40;

}  // namespace skein::vision::detail
