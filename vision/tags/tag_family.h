#pragma once

namespace skein::vision {

/// The ids of the family 36h11 are 0 to this one. A test compares it with AprilTag's own family.
inline constexpr int largest_tag = 586;

}  // namespace skein::vision
