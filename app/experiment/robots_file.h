#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/known_robots.h"

namespace skein::app {

/// Changes of a file of robots on the disk. Other programs' changes at the same time are not lost (file_change.h), and
/// the rest of the file stays unchanged. Errors are sentences, a line each.

/// Adds robots at its end, except those that it has already, by link or by name; creates the file if there is none.
/// Returns how many were added.
tl::expected<std::size_t, std::string> add_to_robots_file(const std::string& file, const std::vector<KnownRobot>& more);

/// Results about a robot: keys of the file of robots with their values as TOML text.
struct FoundRobot {
  RobotSpec spec;
  std::string name;  ///< its name in messages
  std::vector<std::pair<std::string, std::string>> values;
};

struct SavedValues {
  bool changed = false;
  std::size_t robots = 0;             ///< how many of them the file has
  std::vector<std::string> problems;  ///< robots that the file does not have, values that cannot be written
};

/// Writes what was found about its robots.
tl::expected<SavedValues, std::string> save_to_robots_file(const std::string& file,
                                                           const std::vector<FoundRobot>& robots);

}  // namespace skein::app
