#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "vision/calibrate/floor_calibration.h"

namespace skein::app {

/// Reads the places of the marks on the floor (TOML):
///   [[tag]]    id, x, y, z = 0        a tag of the family 36h11
///   [[point]]  u, v, x, y, z = 0      a spot of the floor, and its pixel
/// The error has a line for each problem: file:line:column, what was found and what is allowed.
tl::expected<std::vector<vision::FloorMark>, std::string> load_floor_marks(const std::filesystem::path& path);
tl::expected<std::vector<vision::FloorMark>, std::string> parse_floor_marks(std::string_view text,
                                                                            const std::string& name);

}  // namespace skein::app
