#pragma once

#include <string>
#include <vector>

#include "comms/link_address.h"

namespace skein::app {

/// Robots named in a file, experiment or file of robots, read as leniently as possible: they must be stopped, whatever
/// else is wrong with the file. If it is not TOML, every line `link = "..."` counts.
struct RobotAddresses {
  std::vector<comms::LinkAddress> robots;
  std::vector<std::string> problems;  ///< sentences with their places: robots may be missing
};
RobotAddresses robot_addresses(const std::string& file);

}  // namespace skein::app
