#pragma once

#include <string>

#include <tl/expected.hpp>

#include "vision/frames/frame.h"

namespace skein::vision {

/// Writes a frame as a PNG, over whatever the path held before; its folder is made. The error names the file.
tl::expected<void, std::string> write_png(const Frame& frame, const std::string& path);

}  // namespace skein::vision
