#pragma once

#include <string>
#include <vector>

namespace skein::app {

/// `what`: "tick", "run", "loopback", "links", "radio"; empty: all. `seconds`: how long each measurement of the links takes.
/// Further words go to Google Benchmark.
int bench(const std::string& what, double seconds, std::vector<std::string> arguments);

}  // namespace skein::app
