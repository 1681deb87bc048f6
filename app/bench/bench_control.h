#pragma once

namespace skein::app {

/// The cost of the control tick, each part against a baseline of the same run (docs/benchmarks.md): registered with
/// Google Benchmark.
void register_tick_benchmarks();     ///< one tick of the paper's experiment, and the law alone
void register_control_benchmarks();  ///< law, avoidance and shield for 4 to 1,000 robots
void register_run_benchmark();       ///< `skein run platoon.toml --csv` as a whole
void register_loopback_benchmark();  ///< the same in real time through rendered frames and the robots' protocol: 84 s

}  // namespace skein::app
