#pragma once

#include <string>
#include <tl/expected.hpp>

namespace skein::vision {

/// Whether what is loaded when it is needed can be: films and pictures, calibration boards and sheets, GigE and
/// USB3 Vision cameras. Loads all. The error says which cannot, and where it was looked for.
tl::expected<void, std::string> modules_present();

}  // namespace skein::vision
