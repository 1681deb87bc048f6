#pragma once

#include <string>
#include <tl/expected.hpp>

#include "vision/modules/aravis.h"
#include "vision/modules/boards.h"
#include "vision/modules/media.h"

namespace skein::vision {

/// The functions of skein_media.so, which is loaded at the first call and stays. It is looked for beside the running
/// program, in ../lib/skein/modules from there, and where the build puts it. The error names the places and what was
/// wrong.
tl::expected<const Media*, std::string> media();

/// The same of skein_boards.so.
tl::expected<const Boards*, std::string> boards();

/// The same of skein_aravis.so.
tl::expected<const Aravis*, std::string> aravis();

}  // namespace skein::vision
