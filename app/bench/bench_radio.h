#pragma once

namespace skein::app {

/// The paper's lap over slow radios, and random faults: see docs/emulator.md.
void register_radio_benchmarks();

}  // namespace skein::app
