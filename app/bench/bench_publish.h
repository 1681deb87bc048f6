#pragma once

namespace skein::app {

/// Whether publishing a run (`skein run --publish`) delays its control thread: 30 robots at 25 Hz, and a receiver that
/// takes nothing. Ticks that are published and ticks that are not take turns in the same run, 2 s each.
void register_publish_benchmark(double seconds);

/// How long 10,000 kept runs are searched (`skein runs find`), with their index and without.
void register_runs_benchmark();

}  // namespace skein::app
