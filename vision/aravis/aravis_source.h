#pragma once

#include <memory>
#include <string>

#include "vision/modules/aravis.h"

namespace skein::vision::detail {

/// See Aravis.
std::unique_ptr<FrameSource> open_camera(const std::string& camera, const SourceOptions& options, std::string& error);

}  // namespace skein::vision::detail
