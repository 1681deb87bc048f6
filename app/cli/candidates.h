#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/manual/manual.h"

namespace skein::app {

/// What the shell may complete a value to, by the name of the option or positional: keys of the experiment file and
/// their words for --set, the experiments and studies that Skein comes with, known robots, cameras.
std::optional<std::vector<Candidate>> candidates(const std::string& name);

}  // namespace skein::app
