#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// Conditions on several keys together: (18) along the whole reference, a path inside the arena, robots that are
/// distinct and visible. For an experiment that `read_tables` has filled; each single value is in its range.
void check_together(const Experiment& experiment, Problems& problems);

}  // namespace skein::app
