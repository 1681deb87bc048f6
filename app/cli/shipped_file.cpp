#include "app/cli/shipped_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>
#include <vector>

#include "app/manual/mistakes.h"
#include "app/run/nearest_word.h"
#include "app/run/resources.h"

namespace skein::app {
namespace {

/// Where a name with a folder or an ending is not found, the file is missing, and not the name wrong.
bool is_bare_and_missing(const std::string& name) {
  std::error_code error;
  return !name.empty() && name.find_first_of("/.") == std::string::npos && !std::filesystem::exists(name, error);
}

std::string refusal(const std::string& name, const std::string& folder, const std::vector<std::string>& commands) {
  std::vector<std::string> words = resource_names(folder);
  if (words.empty()) return {};
  const std::string names = fmt::format("{}", fmt::join(words, ", "));
  words.insert(words.end(), commands.begin(), commands.end());
  return fmt::format("found {}{} allowed: {}a file, or one of the {} that come with Skein: {}", name,
                     did_you_mean(name, words),
                     commands.empty() ? "" : fmt::format("a command ({}), ", fmt::join(commands, ", ")), folder, names);
}

}  // namespace

void take_shipped_files(CLI::Option& option, const std::string& folder, const CLI::App* program) {
  option.transform([folder](const std::string& name) { return find_resource(folder, name); });
  option.check([folder, program](const std::string& name) {
    return is_bare_and_missing(name)
               ? refusal(name, folder, program ? names_of_commands(*program) : std::vector<std::string>())
               : std::string();
  });
}

}  // namespace skein::app
