#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/modules/aravis.h"

namespace skein::vision {

/// The cameras that answer within a second. The error: Aravis cannot be loaded.
tl::expected<std::vector<NetworkCamera>, std::string> network_cameras();

/// What the camera of a name or network address offers and its settings, for people, a line each. Does not change it,
/// but no other program may be reading frames from it.
tl::expected<std::vector<std::string>, std::string> describe_network_camera(const std::string& camera);

}  // namespace skein::vision
