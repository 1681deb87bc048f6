#include "app/run/resources.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace skein::app {
namespace {

namespace fs = std::filesystem;

fs::path program_folder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

fs::path resources() {
  std::error_code error;
  const fs::path build = program_folder().parent_path();
  if (build.empty()) return {};
  for (const fs::path& place : {build / "share" / "skein", build.parent_path().parent_path() / "resources"})
    if (fs::is_directory(place / "experiments", error)) return place;
  return {};
}

}  // namespace

std::string find_resource(const std::string& folder, const std::string& name) {
  std::error_code error;
  if (name.empty() || name.find('/') != std::string::npos || fs::exists(name, error)) return name;
  const fs::path place = resources();
  if (place.empty()) return name;
  for (const std::string& file : {name, name + ".toml"})
    if (const fs::path path = place / folder / file; fs::is_regular_file(path, error)) return path.string();
  return name;
}

std::string resource_folder(const std::string& folder) {
  std::error_code error;
  const fs::path place = resources();
  return !place.empty() && fs::is_directory(place / folder, error) ? (place / folder).string() : std::string();
}

std::optional<std::string> missing_resources() {
  if (!resources().empty()) return {};
  return fmt::format(
      "{}: the experiments and studies that come with Skein are not beside this program, as if it had been copied "
      "alone, allowed: where it was installed or built, or a link to that",
      program_folder().string());
}

std::vector<std::string> resource_names(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  const fs::path place = resources();
  if (place.empty()) return names;
  for (fs::directory_iterator it(place / folder, error), end; !error && it != end; it.increment(error))
    if (it->path().extension() == ".toml") names.push_back(it->path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace skein::app
