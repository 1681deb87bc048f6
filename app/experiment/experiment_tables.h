#pragma once

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// Every key of an experiment file, read into the experiment: types, ranges of single values, unknown and missing keys.
/// Conditions on several keys are in experiment_checks.h. docs/experiment-file.md describes this file.
void read_tables(const toml::table& document, Experiment& experiment, Problems& problems);

/// The couplings of (36). In a group of more than six robots the couplings of each pair are smaller, so that their sums
/// in (18f, g) are those of six robots: otherwise tracking would get nothing.
core::CouplingGains paper_couplings(std::size_t robots);

}  // namespace skein::app
