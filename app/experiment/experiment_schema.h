#pragma once

#include <string>

namespace skein::app {

/// A JSON schema of experiment files, for editors that complete and check TOML: resources/experiment.schema.json. It
/// has every key: a key of one value with range, default and help, structured values with their types and words.
std::string experiment_schema();

}  // namespace skein::app
