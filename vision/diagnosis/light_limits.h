#pragma once

namespace skein::vision::detail {

/// Below this contrast the photometric fit is not reliable. [grey levels]
inline constexpr double least_contrast = 12.0;

/// The smallest difference between ink and paper in a search for tags that the tracker does not see. [grey levels]
inline constexpr int faint = 2;

/// The share of pixels at 250 and more from which a frame counts as too bright, and the grey level below which 99 % of
/// the pixels of a dark frame stay.
inline constexpr double saturated_share = 0.25;
inline constexpr int dark_grey = 40;

/// Edges of this width in the median are blurred: a lens in focus gives 2 to 2.5. [px]
inline constexpr double blurred_edge = 3.8;

}  // namespace skein::vision::detail
