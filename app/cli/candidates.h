#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/manual/manual.h"

namespace skein::app {

/// Shell completions of a value, by the name of the option or positional: keys of the experiment file and their words
/// for --set, the experiments and studies that come with Skein, kept runs (of --runs-dir), known robots (of --file),
/// cameras.
std::optional<std::vector<Candidate>> candidates(const std::string& name, const Typed& typed);

}  // namespace skein::app
