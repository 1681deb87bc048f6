#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// Events during a run: [[perturb]] and [[operator]].
void read_events(TomlTable& document, Experiment& experiment);

/// Checks that their robots and obstacles exist, and that their actions are possible.
void check_events(const Experiment& experiment, Problems& problems);

}  // namespace skein::app
