#pragma once

#include <array>

namespace skein::vision {

/// The corners of a tag's black square [px], in AprilTag's own order: as the tag is printed upright bottom-left,
/// bottom-right, top-right, top-left. A robot's heading runs from the left edge to the right one: from 0 to 1, from 3
/// to 2.
using Corners = std::array<std::array<double, 2>, 4>;

/// A tag seen in a frame.
struct Detection {
  int tag = 0;                   // id in the family 36h11, 0..586
  Corners corners{};             // (0, 0) is the centre of the frame's top-left pixel [px]
  double decision_margin = 0.0;  // how far its bits were from the threshold [grey levels]; good tags have 40 and more
  double likeness = 0.0;         // correlation of the picture with this tag's pattern; good tags have 0.85 and
                                 // more (0 where least_likeness is -1)
};

}  // namespace skein::vision
