#pragma once

#include <cstdint>

namespace skein::app {

struct ControllersBench {
  std::int64_t runs = 140;  ///< of the study of adversaries; 0: none
  std::uint64_t seed = 1;   ///< of its first run; the next ones count on
  double seconds = 40.0;    ///< of each of its two measurements of the tick
};

/// What a controller in a process adds to the tick, against the same tick without one; and the study of adversaries.
/// Returns an ExitStatus: expectation_failed where an adversary did harm.
int bench_controllers(const ControllersBench& bench);

}  // namespace skein::app
