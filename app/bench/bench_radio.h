#pragma once

#include <cstdint>

namespace skein::app {

struct RadioBench {
  int faults = 1000;       ///< random fault sequences; 0: none
  std::uint64_t seed = 1;  ///< of the first of them; the next ones count on
};

/// The paper's lap over slow radios: see docs/emulator.md.
void register_radio_benchmarks();

/// Random faults over the same radio: how far a robot drives blind, with links.blind_distance and without. Returns an
/// ExitStatus: expectation_failed if one drove farther than that distance.
int report_radio_faults(const RadioBench& bench);

}  // namespace skein::app
