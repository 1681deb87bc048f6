#include "app/experiment/text_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace skein::app {

tl::expected<std::string, std::vector<Problem>> read_text(const std::string& path) {
  const auto unreadable = [&](const std::string& why) {
    return tl::unexpected(std::vector<Problem>{{path, 0, 0, "cannot be read: " + why}});
  };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return unreadable("it is a directory");
  std::ifstream in(path, std::ios::binary);
  if (!in) return unreadable(std::strerror(errno));
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) return unreadable(std::strerror(errno));
  return text;
}

}  // namespace skein::app
