#include "vision/recording/picture_file.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <vector>

#include "vision/modules/media_loader.h"

namespace skein::vision {

tl::expected<void, std::string> write_png(const Frame& frame, const std::string& path) {
  const auto module = media();
  if (!module) return tl::unexpected(module.error());
  std::vector<std::uint8_t> bytes;
  if (!(*module)->encode_png(frame, bytes)) return tl::unexpected(path + ": this picture cannot be a PNG");
  std::error_code ignored;  // a folder that cannot be made is a file that cannot be written
  std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) return tl::unexpected(path + ": cannot be written");
  return {};
}

}  // namespace skein::vision
