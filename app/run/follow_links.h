#pragma once

#include <optional>
#include <string>

namespace skein::app {

/// The file that a write to `path` reaches through links, also if it is not there yet, as on a disk just plugged in;
/// `path` itself if it is none. None: its links lead round in a circle.
std::optional<std::string> follow_links(const std::string& path);

}  // namespace skein::app
