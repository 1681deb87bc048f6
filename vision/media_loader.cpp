#include "vision/media_loader.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <vector>

namespace skein::vision {
namespace {

tl::expected<const Media*, std::string> load() {
  namespace fs = std::filesystem;
  constexpr const char* file = "skein_media.so";
  std::vector<fs::path> places;
  std::error_code error;
  if (const fs::path program = fs::read_symlink("/proc/self/exe", error); !error) {
    places.push_back(program.parent_path() / file);
    places.push_back(program.parent_path().parent_path() / "lib" / "skein" / file);
  }
#ifdef SKEIN_MEDIA_BUILD_PATH
  places.emplace_back(SKEIN_MEDIA_BUILD_PATH);
#endif
  std::string tried;
  for (const fs::path& place : places) {
    tried += fmt::format("\n  {}: ", place.string());
    if (!fs::exists(place, error)) {
      tried += "no such file";
      continue;
    }
    // Never closed: sources made by the module outlive any handle, and OpenCV does not survive being unloaded.
    void* module = dlopen(place.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (module == nullptr) {
      tried += dlerror();
      continue;
    }
    if (const void* symbol = dlsym(module, media_symbol)) return static_cast<const Media*>(symbol);
    tried += "of another version";
  }
  return tl::unexpected("pictures, videos and MJPEG cameras need the module skein_media.so, which cannot be loaded:" +
                        tried);
}

}  // namespace

tl::expected<const Media*, std::string> media() {
  static const tl::expected<const Media*, std::string> loaded = load();
  return loaded;
}

}  // namespace skein::vision
