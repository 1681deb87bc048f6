#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>
#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/experiment/problem.h"

namespace skein::app {

/// A file of robots, robots.toml: the lab's robots, once for all experiments. docs/robots.md describes it.

struct KnownRobot {
  RobotSpec spec;       ///< with its name and link, as to_text() writes it; tag -1: not given
  std::string version;  ///< of its firmware, as reported in its test; empty: not known
};

/// Reads a file of robots; all problems at once, in the order of the file.
tl::expected<std::vector<KnownRobot>, std::vector<Problem>> load_known_robots(const std::string& path);

/// Whether a file has only [[robot]] tables, so that it is not an experiment.
bool is_file_of_robots(const std::string& path);

/// The file to use: `asked` if it names one, else robots.toml here if there is one, else that of the user,
/// $XDG_CONFIG_HOME/skein/robots.toml (~/.config/skein/robots.toml), and robots.toml here for a user without a home. It
/// need not exist.
std::string known_robots_file(const std::string& asked);

/// Completes every [[robot]] of an experiment whose `name` is in its `robots_file` with the values of that file that
/// the experiment does not set, and drops the key `robots_file`: then one text describes a run completely. Values keep
/// their source places. The file is looked for in `directory` on. True if there was one.
bool embed_known_robots(toml::table& document, const std::string& directory, std::vector<Problem>& problems);

/// Whether it is that robot of an experiment: by its name, or by its link if it has none.
bool is(const KnownRobot& known, const RobotSpec& robot);

/// A robot as a table of the file.
std::string as_toml(const KnownRobot& robot);

/// The text of a file of robots with these added at its end, except those whose link or name it has already.
struct Added {
  std::string text;
  std::size_t robots = 0;
};
Added with_robots(std::string_view text, const std::vector<KnownRobot>& known, const std::vector<KnownRobot>& more);

}  // namespace skein::app
