#pragma once

#include <optional>
#include <string>
#include <vector>

namespace skein::app {

/// Skein's resource files: share/skein beside the folder of the running program, or resources/ of the checkout that it
/// was built in.

/// `name`, unless there is no such file here and a shipped one in `folder` ("experiments", "studies") has it, with or
/// without ".toml": then the path of that.
std::string find_resource(const std::string& folder, const std::string& name);

/// The path of `folder`; empty: there is none.
std::string resource_folder(const std::string& folder);

/// A sentence if nothing that comes with Skein is beside the program, as of one that was copied alone.
std::optional<std::string> missing_resources();

/// The names of those in `folder`, sorted, without ".toml".
std::vector<std::string> resource_names(const std::string& folder);

}  // namespace skein::app
