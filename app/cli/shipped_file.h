#pragma once

#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace skein::app {

/// The option names a file, or by its name alone one in `folder` ("experiments", "studies") of those that come with
/// Skein. A bare name that is neither is refused with the names that there are, and with the commands of `program`,
/// of which it may be one with a slip in it: `skein rnu`.
void take_shipped_files(CLI::Option& option, const std::string& folder, const CLI::App* program = nullptr);

}  // namespace skein::app
