#include "app/cli/same_file.h"

#include <filesystem>

namespace skein::app {

bool same_file(const std::string& a, const std::string& b) {
  std::error_code not_there;
  return !a.empty() && !b.empty() && std::filesystem::equivalent(a, b, not_there);
}

bool same_place(const std::string& a, const std::string& b) {
  const auto plain = [](const std::string& path) {
    std::error_code ignored;
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path), ignored);
  };
  return !a.empty() && !b.empty() && (same_file(a, b) || plain(a) == plain(b));
}

}  // namespace skein::app
