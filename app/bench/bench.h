#pragma once

#include <functional>

namespace skein::app {

/// Measures the window, each time for so many seconds, or its memory in a run of so many hours; empty in a program that
/// was built without one.
using BenchWindow = std::function<int(double seconds, double hours, int& argc, char** argv)>;

/// The program `skein-bench`: measures what its command line names, a row of the table in bench.cpp each. Never throws.
/// Returns an exit status (app/run/exit_status.h).
int bench(int argc, char** argv, const BenchWindow& bench_window = {});

}  // namespace skein::app
