#pragma once

namespace skein::app {

/// Whether publishing a run (`skein run --publish`) delays its control thread: 30 robots at 25 Hz, and a receiver that
/// takes nothing. Publishing is switched on and off in turn within the same run, for 2 s each.
void register_publish_benchmark(double seconds);

/// How long a search of 10,000 kept runs takes (`skein runs find`), with their index and without.
void register_runs_benchmark();

}  // namespace skein::app
