#pragma once

#include <cstdint>

namespace skein::app {

struct IdentifyBench {
  std::int64_t runs = 1000;  ///< of each manoeuvre
  std::uint64_t seed = 1;    ///< of the first robot; the next ones count on
};

/// The results of `skein identify` for simulated robots with random, known deviations from the nominal dimensions: how
/// often its 95 % intervals contain the true values, how wide they are, and how much drift remains in a minute of
/// driving without measurements. Three manoeuvres: the recommended one, UMBmark's squares of the same length, also with
/// UMBmark's own estimator, and the paper's lap. Returns an ExitStatus: expectation_failed if an interval of the
/// recommended manoeuvre contains the true value in fewer than 93 % or more than 97 % of the runs.
int bench_identify(const IdentifyBench& bench);

}  // namespace skein::app
