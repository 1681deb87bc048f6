#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/modules/aravis.h"

namespace skein::vision {

/// The cameras that answer within a second. The error: Aravis cannot be loaded.
tl::expected<std::vector<NetworkCamera>, std::string> network_cameras();

/// The modes and settings of the camera with this name or network address, one line each, for the operator. Does not
/// change the camera, but no other program may be reading frames from it.
tl::expected<std::vector<std::string>, std::string> describe_network_camera(const std::string& camera);

}  // namespace skein::vision
