#pragma once

#include <array>
#include <vector>

namespace skein::vision::detail {

/// Of a tag's side, white border and all; the black square has 8.
inline constexpr int pattern_cells = 10;

/// true: paper, false: ink; row by row from the top left as printed upright.
using TagPattern = std::array<bool, pattern_cells * pattern_cells>;

/// AprilTag's own images of the family 36h11 by id, so that drawing, tracking and detection use the same tags.
std::vector<TagPattern> tag_patterns();

}  // namespace skein::vision::detail
