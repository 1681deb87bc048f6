#pragma once

#include <string>

namespace skein::app {

/// A JSON schema of experiment files, for editors that complete and check TOML: resources/experiment.schema.json. It
/// describes every key with one value; structured values it only names.
std::string experiment_schema();

}  // namespace skein::app
