#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/pose.h"

namespace skein::core {

/// Neighbour search: robots are sorted into square cells, so that the cost of a search grows with the number of
/// neighbours and not with that of the group. Only the constructor allocates.
class NearRobots {
 public:
  explicit NearRobots(std::size_t robots);

  /// Sorts the robots by their present positions; robots without a pose (NaN) are no neighbours. `reach`: the range of
  /// `around` [m].
  void sort(std::span<const Pose> poses, double reach) noexcept;

  /// Every other robot whose x and y differ by no more than the reach, in rising order, and possibly some farther ones;
  /// or, with `above`, only those with a number above i. Valid until the next call.
  std::span<const std::uint32_t> around(std::size_t i) noexcept { return gather(i, 0); }
  std::span<const std::uint32_t> above(std::size_t i) noexcept { return gather(i, i + 1); }

  /// The smallest distance between any two robots, exactly as a comparison of all pairs gives it; NaN for fewer than
  /// two. Sorts again.
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
  std::vector<std::uint32_t> near_;    // the result of `around`
  double last_reach_ = 0.1;            // the reach that `smallest_distance` last needed [m]
};

}  // namespace skein::core
