#pragma once

#include <string>
#include <string_view>

namespace skein::app {

/// A cell of a run's CSV that is not empty, as JSON: a number as it is written, else a string.
std::string json_cell(std::string_view cell, bool words);

}  // namespace skein::app
