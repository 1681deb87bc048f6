#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/problem.h"

namespace skein::app {

/// The whole of a text file; the problem says why it cannot be read.
tl::expected<std::string, std::vector<Problem>> read_text(const std::string& path);

}  // namespace skein::app
