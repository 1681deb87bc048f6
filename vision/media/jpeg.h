#pragma once

#include <cstdint>
#include <span>

#include "vision/frames/frame.h"
#include "vision/modules/media.h"

namespace skein::vision::media {

/// A truncated JPEG decodes without an error, its lower part grey. It has no end marker behind its start of a scan;
/// neither marker occurs among coded pixels. Phones put a film behind that end, which holds any bytes.
bool jpeg_breaks_off(std::span<const std::uint8_t> bytes);

/// See Media::decode_jpeg. A decoder goes on behind a bit that was flipped or bytes that are lost, and all blocks
/// behind it may stand elsewhere, with sharp tags in them. It warns where it meets a code that does not exist, and
/// where the coded blocks are too few or too many up to the next marker.
JpegState decode_jpeg(std::span<const std::uint8_t> bytes, Frame& frame);

}  // namespace skein::vision::media
