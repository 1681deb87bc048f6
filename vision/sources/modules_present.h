#pragma once

#include <string>
#include <tl/expected.hpp>

namespace skein::vision {

/// Whether the modules that are loaded on demand are present: films and pictures, calibration boards and sheets, GigE
/// and USB3 Vision cameras. Loads all of them. The error names those that cannot be loaded and the places searched.
tl::expected<void, std::string> modules_present();

}  // namespace skein::vision
