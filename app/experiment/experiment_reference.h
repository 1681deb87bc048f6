#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// Reads [reference]; the robots must be known, since a formation may give each its place.
void read_reference(TomlTable table, Experiment& experiment, Problems& problems);

/// Whether a path and a formation can be made of what was read.
bool check_shape(const Experiment& experiment, Problems& problems);
/// That the robots stay in the arena, and that the formation neither collides nor sets off what keeps robots apart.
/// Requires `check_shape`.
void check_places(const Experiment& experiment, const core::Reference& reference, Problems& problems);

}  // namespace skein::app
