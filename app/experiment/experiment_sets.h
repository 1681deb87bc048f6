#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "app/experiment/problem.h"

namespace skein::app {

/// Puts the values of --set "key=value" into a document: dotted keys, tables of an array counted from 1
/// ("robot.2.tag=7"; the next free number adds one), values as in TOML, where a bare word is read as a string. New
/// values have
/// "--set key=value" as their source path. Values that cannot be set are added to `problems`.
void apply_sets(toml::table& document, const std::vector<std::string>& sets, std::vector<Problem>& problems);

}  // namespace skein::app
