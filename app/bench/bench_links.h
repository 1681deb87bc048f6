#pragma once

namespace skein::app {

/// Registers `skein-bench links` with Google Benchmark: links to emulated robots on pseudo-terminals at 25 Hz, each for
/// `seconds`.
void register_link_benchmarks(double seconds);

}  // namespace skein::app
