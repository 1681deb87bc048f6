#pragma once

#include <string_view>
#include <vector>

#include "vision/frames/frame.h"
#include "vision/tags/detection.h"

namespace skein::vision {

/// What a tag may be printed in, or look like. The first three are 36h11.
struct TagFamily {
  std::string_view name;
  bool has_ghosts = false;  // so few bits that a texture may look like a tag
};
inline constexpr std::string_view in_36h11 = "36h11", in_mirror = "36h11 mirrored", in_negative = "36h11 in negative";

/// A tag in a picture. `seen.likeness` is 0 outside of 36h11, corners are in the order of the tag as it appears.
struct FamilyTag {
  const TagFamily* family;
  Detection seen;
};

/// All tags of AprilTag's families in a still picture, at full and at half resolution, each once; ordered by family, id
/// and place. Of 36h11 also those in a mirror, and those whose black and white are exchanged, in print or by the
/// camera. The search for squares takes most of the time, and is made once for all families at each resolution.
/// Builds its tables anew (~0.1 s): not for pictures of a film. `min_white_black_diff` as for DetectorOptions.
std::vector<FamilyTag> read_families(const Frame& frame, int min_white_black_diff);

/// The tags of one family, by its name.
std::vector<Detection> of_family(const std::vector<FamilyTag>& tags, std::string_view family);

}  // namespace skein::vision
