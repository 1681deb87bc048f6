#pragma once

#include <functional>

namespace skein::app {

/// Measures the window: each measurement takes `seconds`; with `hours` above 0, its memory during a run of that length
/// instead. Empty in a program that was built without a window.
using BenchWindow = std::function<int(double seconds, double hours, int& argc, char** argv)>;

/// The program `skein-bench`: measures what its command line names, a row of the table in bench.cpp each. Never throws.
/// Returns an exit status (app/run/exit_status.h).
int bench(int argc, char** argv, const BenchWindow& bench_window = {});

}  // namespace skein::app
