#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// Reads a robot's `trajectory`.
void read_trajectory(TomlTable t, TrajectorySpec& trajectory);

/// Checks that the robots have trajectories if and only if the reference requires them, and that they can be driven.
bool check_trajectories(const Experiment& experiment, Problems& problems);
/// Checks that every robot's trajectory leaves a part of the limits to the law (18f, g). Requires `check_trajectories`.
void check_trajectory_speeds(const Experiment& experiment, Problems& problems);

/// When the last robot comes to rest; infinite if one never does. Requires `check_trajectories`. [s]
double last_arrival(const Experiment& experiment);

}  // namespace skein::app
