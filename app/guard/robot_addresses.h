#pragma once

#include <string>
#include <vector>

#include "comms/link_address.h"

namespace skein::app {

/// Robots that a file names, experiment or file of robots, read as leniently as can be: they are to be stopped,
/// whatever else is wrong with the file. Where it is no TOML, every line `link = "..."` counts.
struct RobotAddresses {
  std::vector<comms::LinkAddress> robots;
  std::vector<std::string> problems;  ///< sentences with their places: robots may be missing
};
RobotAddresses robot_addresses(const std::string& file);

}  // namespace skein::app
