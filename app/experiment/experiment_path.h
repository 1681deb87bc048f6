#pragma once

#include <string>

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// [[x, y], ...], from `least` to `most` of them. [m]
void read_points(TomlTable& t, const char* key, std::vector<core::Point>& points, std::size_t least, std::size_t most);

/// A path's table. `closed`: whether a line through points is closed by default.
void read_path(TomlTable t, PathSpec& path, bool closed);

/// Checks that the values read at `key` ("reference.path") give a path.
bool check_path(const PathSpec& path, const std::string& key, Problems& problems);

}  // namespace skein::app
