#include "app/cli/same_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "vision/sources/open_source.h"

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

bool is_stdout(const std::string& path) {
  struct stat file {
  }, out{};
  return ::stat(path.c_str(), &file) == 0 && ::fstat(STDOUT_FILENO, &out) == 0 && file.st_dev == out.st_dev &&
         file.st_ino == out.st_ino;
}

bool belongs_to_source(const std::string& path, const std::string& source) {
  namespace fs = std::filesystem;
  const auto address = vision::parse_source(source);
  if (!address || address->live() || path.empty()) return false;
  std::error_code ignored;
  const fs::path file(path), folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const bool a_picture =
      file.extension() != ".toml" && fs::exists(file, ignored) && same_file(folder.string(), address->where);
  return a_picture || same_file(path, address->where);
}

}  // namespace skein::app
