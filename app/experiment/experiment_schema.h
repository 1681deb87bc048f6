#pragma once

#include <string>

namespace skein::app {

/// A JSON schema of experiment files, for editors that complete and check TOML: resources/experiment.schema.json. It
/// knows every key with one value; what has a structure of its own it only names.
std::string experiment_schema();

}  // namespace skein::app
