#pragma once

#include <cstdint>

namespace skein::app {

struct SwapsBench {
  std::int64_t runs = 40;  ///< scenes of each number of robots
  std::uint64_t seed = 1;  ///< of the first of them; the next ones count on
};

/// Robots at random places drive to random places: by Skein's planned routes, by detours, by the paper's field alone,
/// and by methods from the literature (`SwapMethod`), on the same scenes. Prints a table with a row for each number of
/// robots and method. Returns an ExitStatus: expectation_failed if, with planned routes, a robot does not arrive or two
/// touch.
int bench_swaps(const SwapsBench& bench);

}  // namespace skein::app
