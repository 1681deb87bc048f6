#pragma once

#include <cstdint>

namespace skein::app {

struct IdentifyBench {
  std::int64_t runs = 1000;  ///< of each manoeuvre
  std::uint64_t seed = 1;    ///< of the first robot; the next ones count on
};

/// What `skein identify` finds of robots that are known, each other than the drawing by chance: how often its 95 %
/// intervals hold the truth, how wide they are, and what is left of the drift of a minute that is driven blindly; after
/// UMBmark's squares also what its own estimator finds. After the recommended manoeuvre, after UMBmark's squares of the
/// same way, and after the paper's lap. Returns an ExitStatus: expectation_failed where an interval of the recommended
/// manoeuvre holds in fewer than 93 or more than 97 % of the runs.
int bench_identify(const IdentifyBench& bench);

}  // namespace skein::app
