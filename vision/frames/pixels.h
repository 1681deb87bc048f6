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

/// The same for a plane of grey levels before planes of colours, which together have half as many bytes for each of
/// `halves`. false also where only bytes of the colours are missing: what was lost may have stood anywhere, and all
/// that comes after it has moved.
template <int halves>
bool grey_from_plane(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width), height = static_cast<std::size_t>(frame.height);
  stride = std::max(stride, width);
  const std::size_t whole = stride * height + stride * height * halves / 2;
  return bytes.size() + (stride - width) >= whole && grey_from_grey(bytes, stride, frame);
}

namespace detail {

/// Every other byte of a row, from `first` on.
inline bool grey_from_bytes(std::span<const std::uint8_t> bytes, std::size_t stride, std::size_t first, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  stride = std::max(stride, 2 * width);
  if (bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + 2 * width) return false;
  for (int v = 0; v < frame.height; ++v) {
    const std::uint8_t* from = bytes.data() + stride * static_cast<std::size_t>(v) + first;
    std::uint8_t* to = frame.row(v);
    for (std::size_t u = 0; u < width; ++u) to[u] = from[2 * u];
  }
  return true;
}

}  // namespace detail

/// The same for YUYV: two pixels in four bytes, Y0 U Y1 V; the grey is every other byte.
inline bool grey_from_yuyv(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  return detail::grey_from_bytes(bytes, stride, 0, frame);
}

/// The same for UYVY: U Y0 V Y1.
inline bool grey_from_uyvy(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  return detail::grey_from_bytes(bytes, stride, 1, frame);
}

/// The same for grey levels of `bits` bits, each in two bytes, the lower one first: their highest eight bits.
template <int bits>
bool grey_from_words(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  stride = std::max(stride, 2 * width);
  if (bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + 2 * width) return false;
  for (int v = 0; v < frame.height; ++v) {
    const std::uint8_t* from = bytes.data() + stride * static_cast<std::size_t>(v);
    std::uint8_t* to = frame.row(v);
    for (std::size_t u = 0; u < width; ++u)
      to[u] = static_cast<std::uint8_t>(std::min(255, (from[2 * u] | from[2 * u + 1] << 8) >> (bits - 8)));
  }
  return true;
}

/// The same for grey levels of `bits` bits without gaps between them (GenICam's Mono10p, Mono12p), the lowest bit
/// first.
template <int bits>
bool grey_from_packed(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  const std::size_t used = (width * bits + 7) / 8;
  stride = std::max(stride, used);
  if (bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + used) return false;
  for (int v = 0; v < frame.height; ++v) {
    const std::uint8_t* from = bytes.data() + stride * static_cast<std::size_t>(v);
    std::uint8_t* to = frame.row(v);
    for (std::size_t u = 0; u < width; ++u) {
      const std::size_t bit = bits * u + bits - 8;
      const unsigned next = bit % 8 == 0 ? 0u : from[bit / 8 + 1];
      to[u] = static_cast<std::uint8_t>((from[bit / 8] | next << 8) >> (bit % 8));
    }
  }
  return true;
}

/// The same for GigE Vision's own packing (Mono10Packed, Mono12Packed): two pixels in three bytes, of which the first
/// and the last have the highest eight bits.
inline bool grey_from_gige_packed(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  const std::size_t used = (3 * width + 1) / 2;
  stride = std::max(stride, used);
  if (bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + used) return false;
  for (int v = 0; v < frame.height; ++v) {
    const std::uint8_t* from = bytes.data() + stride * static_cast<std::size_t>(v);
    std::uint8_t* to = frame.row(v);
    for (std::size_t u = 0; u < width; ++u) to[u] = from[u / 2 * 3 + (u % 2 == 0 ? 0 : 2)];
  }
  return true;
}

/// The same for three colours in three bytes, green in the middle: a quarter, a half, a quarter.
inline bool grey_from_rgb(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  stride = std::max(stride, 3 * width);
  if (bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + 3 * width) return false;
  for (int v = 0; v < frame.height; ++v) {
    const std::uint8_t* from = bytes.data() + stride * static_cast<std::size_t>(v);
    std::uint8_t* to = frame.row(v);
    for (std::size_t u = 0; u < width; ++u)
      to[u] = static_cast<std::uint8_t>((from[3 * u] + 2 * from[3 * u + 1] + from[3 * u + 2] + 2) / 4);
  }
  return true;
}

/// The same for raw colours of `bits` bits, in a byte or, from 9 on, in two with the lower one first: weights 1 2 1 in
/// both directions give every pixel a quarter of red, a quarter of blue and half of green, wherever the pattern of
/// colours begins, and shift nothing.
template <int bits = 8>
bool grey_from_bayer(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame) {
  constexpr std::size_t each = bits > 8 ? 2 : 1;  // bytes
  const auto width = static_cast<std::size_t>(frame.width);
  stride = std::max(stride, each * width);
  if (frame.width < 2 || frame.height < 2 ||
      bytes.size() < stride * static_cast<std::size_t>(frame.height - 1) + each * width)
    return false;
  const auto row = [&](int v) {  // mirrored at the borders, which keeps the pattern
    const int inside = v < 0 ? 1 : v >= frame.height ? frame.height - 2 : v;
    return bytes.data() + stride * static_cast<std::size_t>(inside);
  };
  const auto level = [](const std::uint8_t* from, std::size_t u) -> int {
    if constexpr (each == 1)
      return from[u];
    else
      return std::min(255, (from[2 * u] | from[2 * u + 1] << 8) >> (bits - 8));
  };
  for (int v = 0; v < frame.height; ++v) {
    const std::uint8_t* above = row(v - 1);
    const std::uint8_t* here = row(v);
    const std::uint8_t* below = row(v + 1);
    const auto column = [&](std::size_t u) { return level(above, u) + 2 * level(here, u) + level(below, u); };
    std::uint8_t* to = frame.row(v);
    for (std::size_t u = 0; u < width; ++u) {
      const std::size_t left = u == 0 ? 1 : u - 1;
      const std::size_t right = u + 1 == width ? width - 2 : u + 1;
      to[u] = static_cast<std::uint8_t>((column(left) + 2 * column(u) + column(right) + 8) / 16);
    }
  }
  return true;
}

}  // namespace skein::vision
