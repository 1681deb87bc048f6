#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "app/experiment/experiment.h"
#include "app/experiment/problem.h"

namespace skein::app {

/// Puts the values of --set "key=value" into a document: dotted keys, tables of an array counted from 1
/// ("robot.2.tag=7"; the next free number adds one), values as in TOML, where a bare word is read as a string. New
/// values have "--set key=value" as their source path. Values that cannot be set are added to `problems`.
void apply_sets(toml::table& document, const std::vector<std::string>& sets, std::vector<Problem>& problems);

/// The values of --set that turn `before` into `after`; a key at the top that `after` no longer has is left out, since
/// --set cannot remove a key. Both are texts of experiments.
std::vector<std::string> sets_between(std::string_view before, std::string_view after);

/// The value of --set that adds an action of the operator: `number`, from 1, is its place in the file's [[operator]].
std::string set_of(const OperatorAction& action, std::size_t number);

}  // namespace skein::app
