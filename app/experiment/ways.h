#pragma once

#include <string>
#include <vector>

#include "app/experiment/experiment.h"

namespace skein::app {

/// Where obstacles and the arena's edge leave a robot no way from where it begins to where its reference comes to rest,
/// were nobody else there and it kept what the shield keeps: a sentence for each such robot. To places that drive on
/// nothing is looked for.
std::vector<std::string> missing_ways(const Experiment& experiment);

}  // namespace skein::app
