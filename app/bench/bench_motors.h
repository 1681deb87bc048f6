#pragma once

namespace skein::app {

/// How far emulated e-pucks stay behind their references at a steady 0.05 m/s, and how far if the tick assumes ideal
/// motors. Returns an ExitStatus: expectation_failed if an e-puck1 is off by more than 0.5 mm.
int bench_motors();

}  // namespace skein::app
