#include "app/experiment/text_file.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace skein::app {

namespace {

constexpr std::uintmax_t largest_text = std::uintmax_t{64} << 20;  // [bytes]

/// Why it is no file to read; empty: it is one, or opening it says more.
std::string not_a_file(const std::string& path) {
  std::error_code ignored;
  const std::filesystem::file_status found = std::filesystem::status(path, ignored);
  if (std::filesystem::is_directory(found)) return "it is a folder, allowed: a file";
  if (std::filesystem::exists(found) && !std::filesystem::is_regular_file(found))
    return "it is a device or a FIFO, allowed: a file";
  return {};
}

}  // namespace

tl::expected<void, std::string> check_is_file(const std::string& path) {
  if (const std::string why = not_a_file(path); !why.empty()) return tl::unexpected(path + ": cannot be read: " + why);
  return {};
}

tl::expected<std::string, std::vector<Problem>> read_text(const std::string& path) {
  const auto unreadable = [&](const std::string& why) {
    return tl::unexpected(std::vector<Problem>{{path, 0, 0, "cannot be read: " + why}});
  };
  if (const std::string why = not_a_file(path); !why.empty()) return unreadable(why);
  std::error_code not_known;
  const std::uintmax_t size = std::filesystem::file_size(path, not_known);
  if (!not_known && size > largest_text)
    return unreadable("it has " + std::to_string(size) + " bytes, allowed: at most " + std::to_string(largest_text));
  std::ifstream in(path, std::ios::binary);
  if (!in) return unreadable(std::strerror(errno));
  std::string text(not_known ? 0 : size, '\0');  // at once, which is faster than one by one
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  for (std::array<char, 4096> more; in;) {  // of one that grows, or has no size
    in.read(more.data(), more.size());
    text.append(more.data(), static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) return unreadable(std::strerror(errno));
  return text;
}

}  // namespace skein::app
