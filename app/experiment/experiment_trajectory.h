#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// Reads a robot's `trajectory`.
void read_trajectory(TomlTable t, TrajectorySpec& trajectory);

/// Whether the robots have trajectories exactly where the reference asks for them, and they can be driven.
bool check_trajectories(const Experiment& experiment, Problems& problems);
/// That every robot's trajectory leaves something of the limits to the law (18f, g). Requires `check_trajectories`.
void check_trajectory_speeds(const Experiment& experiment, Problems& problems);

/// When the last robot comes to rest; infinite where one never does. Requires `check_trajectories`. [s]
double last_arrival(const Experiment& experiment);

}  // namespace skein::app
