#pragma once

#include <cstddef>

namespace skein::vision {

/// All tags of a frame look larger or smaller than they did.
struct ScaleChange {
  double by = 0.0;  // as a part of their size; above 0: larger
  std::size_t tags = 0;
};

}  // namespace skein::vision
