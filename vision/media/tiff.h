#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace skein::vision::media {

/// Makes a TIFF ask for no turn: OpenCV turns it even if told not to. Returns empty, or why its reader would take
/// something else than the one picture of the file; empty also for bytes of another format.
std::string prepare_tiff(std::span<std::uint8_t> bytes);

}  // namespace skein::vision::media
