#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "app/experiment/problem.h"

namespace skein::app {

/// Puts the lines of every robot's `trajectory.csv` into the document as `trajectory.samples`, so that one text
/// describes a run completely. The file, t,x,y or t,x,y,theta, is looked for in `directory` on. True if there was any.
bool embed_samples(toml::table& document, const std::string& directory, std::vector<Problem>& problems);

}  // namespace skein::app
