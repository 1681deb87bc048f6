#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "vision/frames/frame.h"
#include "vision/frames/pixels.h"
#include "vision/v4l2/v4l2_device.h"

namespace skein::vision::detail {

/// A kind of pixels that grey can be made of. `to_grey` is null for JPEG, which a module decodes.
struct PixelFormat {
  std::uint32_t number;  // the kernel's
  bool (*to_grey)(std::span<const std::uint8_t> bytes, std::size_t stride, Frame& frame);
};

/// None where the kernel's number is of no such kind.
const PixelFormat* pixel_format(std::uint32_t number);

/// What is wanted of a camera.
struct WantedFormat {
  int width = 0;         // [px]; 0: any
  int height = 0;        // [px]
  double rate = 0.0;     // [frames/s]; 0: any
  std::string format{};  // four letters ("MJPG"); empty: any
};

/// The cheapest format that gives size and rate, in the order of what its frames cost: grey as it is, grey in a plane
/// of its own, grey among colours, 16 bits, raw colours, JPEG. Where none gives the rate, the fastest at this size. A
/// driver that does not list sizes or rates is taken to give any. The error says what the camera offers.
tl::expected<const PixelFormat*, std::string> choose_format(const V4l2Device& device, const WantedFormat& wanted);

}  // namespace skein::vision::detail
