#pragma once

#include <span>

#include "app/experiment/toml_table.h"
#include "vision/calibration/floor_mark.h"

namespace skein::app {

/// Of a pixel's coordinates; a mark may lie on the border of the picture.
inline constexpr Range pixel_range = between(-1.0, 32768.0, "px");

/// Reads the tag with this key, if there is one, and names the mark after it; the tag must not occur in `before`.
void read_tag(TomlTable& t, const char* key, std::span<const vision::FloorMark> before, vision::FloorMark& mark,
              Problems& problems);
/// x, y and z.
void read_place(TomlTable& t, vision::FloorMark& mark);

}  // namespace skein::app
