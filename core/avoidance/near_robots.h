#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/pose.h"

namespace skein::core {

/// Who is near whom: robots sorted into square cells, so that looking around one costs what is near it and not what
/// there is. Allocates when it is made, never later.
class NearRobots {
 public:
  explicit NearRobots(std::size_t robots);

  /// Sorts the robots where they stand now; those whose pose is not known (NaN) are nobody's neighbours. `reach`: how
  /// far `around` must see [m].
  void sort(std::span<const Pose> poses, double reach) noexcept;

  /// Every other robot whose x and y differ by no more than the reach, in rising order, and perhaps some that are
  /// farther; or, with `above`, only those of them behind robot i. Valid until the next call.
  std::span<const std::uint32_t> around(std::size_t i) noexcept { return gather(i, 0); }
  std::span<const std::uint32_t> above(std::size_t i) noexcept { return gather(i, i + 1); }

  /// The smallest distance between any two, as looking at every pair gives it; NaN where there are no two. Sorts anew.
  double smallest_distance(std::span<const Pose> poses) noexcept;

 private:
  struct Cell {
    std::int64_t x, y;
    bool known;
  };
  std::size_t bucket(std::int64_t x, std::int64_t y) const noexcept;
  std::span<const std::uint32_t> gather(std::size_t i, std::size_t first) noexcept;

  std::size_t buckets_;                // a power of two
  std::vector<Cell> cells_;            // of each robot
  std::vector<std::uint32_t> begin_;   // of each bucket in `sorted_`, and the last one's end
  std::vector<std::uint32_t> sorted_;  // robots by bucket, in each bucket in rising order
  std::vector<std::uint32_t> near_;    // what `around` gives
  double last_reach_ = 0.1;            // that `smallest_distance` needed last [m]
};

}  // namespace skein::core
