#pragma once

#include <string>
#include <vector>

#include "app/experiment/experiment.h"

namespace skein::app {

/// A sentence for each robot for which obstacles and the arena's edge leave no way from its start to the place where
/// its reference comes to rest, even without other robots, at the shield's distance. References that never come to rest
/// are not checked.
std::vector<std::string> missing_ways(const Experiment& experiment);

}  // namespace skein::app
