#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// What several keys together must fulfil: (18) along the whole reference, a path inside the arena, robots that are
/// told apart and can be seen. For an experiment that `read_tables` has filled; each single value is in its range.
void check_together(const Experiment& experiment, Problems& problems);

}  // namespace skein::app
