#pragma once

#include <memory>
#include <string>

#include "vision/frames/frame_source.h"
#include "vision/v4l2/v4l2_kernel.h"

namespace skein::vision {

/// A camera through the kernel's V4L2 interface, its memory-mapped buffers read where the driver wrote them. See
/// open_source.
tl::expected<std::unique_ptr<FrameSource>, std::string> open_v4l2(const std::string& device,
                                                                  const SourceOptions& options,
                                                                  V4l2Kernel& kernel = system_kernel());

}  // namespace skein::vision
