#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// Reads [reference]; the robots must be known, since a formation may give each its place.
void read_reference(TomlTable table, Experiment& experiment, Problems& problems);

/// Gives the ends of interchangeable lines to the robots so that all have room and a way, and the sum of the squares of
/// their ways is the smallest: robots that drove them in the same time would not meet (`turpin2014`), and the longest
/// way is short. Requires all tables that say what room there is.
void exchange_places(Experiment& experiment, Problems& problems);

/// Checks that the values read give a path and a formation.
bool check_shape(const Experiment& experiment, Problems& problems);
/// The tables without errors of their own: checks skip the others, whose values may be defaults in place of wrong ones.
struct SoundTables {
  bool arena = true, avoidance = true, shield = true, obstacles = true;
};

/// Checks that the robots stay in the arena, and that the formation neither collides nor triggers avoidance or shield.
/// Requires `check_shape`.
void check_places(const Experiment& experiment, const core::Reference& reference, const SoundTables& sound,
                  Problems& problems);

}  // namespace skein::app
