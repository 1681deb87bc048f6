#include "app/run/follow_links.h"

#include <filesystem>
#include <system_error>

namespace skein::app {

// Not canonical(), which needs the file to be there.
std::optional<std::string> follow_links(const std::string& path) {
  constexpr int most_links = 40;  // as the kernel follows
  std::filesystem::path file = path;
  for (int links = 0; links <= most_links; ++links) {
    std::error_code none;
    const std::filesystem::path target = std::filesystem::read_symlink(file, none);
    if (none) return file.string();
    file = file.parent_path() / target;
  }
  return {};
}

}  // namespace skein::app
