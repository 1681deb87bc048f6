#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "app/experiment/problem.h"

namespace skein::app {

/// Puts the values of --set "key=value" into a document: dotted keys, tables of an array counted from 1
/// ("robot.2.tag=7"; one more than there are adds one), values as in TOML, where a bare word counts as a text. What is
/// put there carries
/// "--set key=value" as its source path. What cannot be put there is added to `problems`.
void apply_sets(toml::table& document, const std::vector<std::string>& sets, std::vector<Problem>& problems);

}  // namespace skein::app
