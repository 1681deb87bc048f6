#pragma once

#include <optional>
#include <string>

namespace skein::app {

/// The file that is written where `path` is a link, also if it is not there yet, as on a disk that was just plugged in;
/// `path` itself if it is none. None: its links lead round in a circle.
std::optional<std::string> behind_links(const std::string& path);

}  // namespace skein::app
