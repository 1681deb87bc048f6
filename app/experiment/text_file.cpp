#include "app/experiment/text_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "app/experiment/file_change.h"

namespace skein::app {

namespace {

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

tl::expected<std::string, std::vector<Problem>> read_text(const std::string& path, std::uintmax_t largest) {
  const auto unreadable = [&](const std::string& why) {
    return tl::unexpected(std::vector<Problem>{{path, 0, 0, "cannot be read: " + why}});
  };
  if (const std::string why = not_a_file(path); !why.empty()) return unreadable(why);
  std::error_code not_known;
  const std::uintmax_t size = std::filesystem::file_size(path, not_known);
  if (!not_known && size > largest)
    return unreadable("it has " + std::to_string(size) + " bytes, allowed: at most " + std::to_string(largest));
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

tl::expected<void, std::string> write_file(const std::string& path, std::string_view text) {
  std::error_code unknown;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const bool can_be_new = folder.empty() || std::filesystem::is_directory(folder, unknown);
  const bool is_new = std::filesystem::symlink_status(path, unknown).type() == std::filesystem::file_type::not_found;
  if (is_new ? can_be_new : std::filesystem::is_regular_file(path, unknown))
    if (auto change = FileChange::begin(path)) return change->save(text);
  // A device, a pipe, a link to what is not there yet, or a file that may be changed in a folder that may not.
  errno = 0;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  if (out) return {};
  return tl::unexpected(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

tl::expected<void, std::string> check_can_write(const std::string& path) {
  std::error_code unknown;
  const std::filesystem::file_status there = std::filesystem::status(path, unknown);
  const bool is_new = !std::filesystem::exists(there);
  // Whoever reads from a FIFO would take the end of a test for the end of the file.
  if (!is_new && !std::filesystem::is_regular_file(there) && !std::filesystem::is_directory(there)) return {};
  errno = 0;
  if (!std::ofstream(path, std::ios::binary | std::ios::app))
    return tl::unexpected(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
  if (is_new) std::filesystem::remove(std::filesystem::canonical(path, unknown), unknown);  // a link to it stays
  return {};
}

}  // namespace skein::app
