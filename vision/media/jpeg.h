#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace skein::vision::media {

/// A truncated JPEG decodes without an error, its lower part grey. It has no end marker behind its last start of a
/// scan; neither marker occurs among coded pixels.
inline bool jpeg_breaks_off(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 4 || bytes[0] != 0xff || bytes[1] != 0xd8) return false;
  for (std::size_t i = bytes.size() - 1; i > 0; --i) {
    if (bytes[i - 1] != 0xff) continue;
    if (bytes[i] == 0xd9) return false;
    if (bytes[i] == 0xda) return true;
  }
  return true;
}

}  // namespace skein::vision::media
