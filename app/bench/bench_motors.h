#pragma once

namespace skein::app {

/// How far emulated e-pucks stay behind their references at a steady 0.05 m/s, and how far where the tick takes their
/// motors for even ones. Returns an ExitStatus: expectation_failed where an e-puck1 misses 0.5 mm.
int bench_motors();

}  // namespace skein::app
