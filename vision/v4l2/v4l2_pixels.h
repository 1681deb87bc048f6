#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "vision/frames/frame.h"

namespace skein::vision {

/// A camera's raw rows, `stride` bytes apart (0: no gaps), into a frame that already has its size. false: bytes are
/// missing.
inline bool grey_from_grey(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  stride = std::max(stride, width);
  if (bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + width) return false;
  for (int v = 0; v < frame.height; ++v) {
    std::copy_n(bytes.data() + stride * static_cast<std::size_t>(v), width, frame.row(v));
  }
  return true;
}

/// The same for YUYV: two pixels in four bytes, Y0 U Y1 V; the grey is every other byte.
inline bool grey_from_yuyv(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  stride = std::max(stride, 2 * width);
  if (bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + 2 * width) return false;
  for (int v = 0; v < frame.height; ++v) {
    const std::uint8_t* from = bytes.data() + stride * static_cast<std::size_t>(v);
    std::uint8_t* to = frame.row(v);
    for (std::size_t u = 0; u < width; ++u) to[u] = from[2 * u];
  }
  return true;
}

}  // namespace skein::vision
