#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// What happens to a run on its way: [[perturb]] and [[operator]].
void read_events(TomlTable& document, Experiment& experiment);

/// What they name has to be there, and what they do has to be possible.
void check_events(const Experiment& experiment, Problems& problems);

}  // namespace skein::app
