#include "vision/modules/media_loader.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <vector>

namespace skein::vision {
namespace {

/// A symbol of a module, which is looked for where media_loader.h says.
tl::expected<const void*, std::string> load(const char* file, const char* symbol_name) {
  namespace fs = std::filesystem;
  std::vector<fs::path> places;
  std::error_code error;
  if (const fs::path program = fs::read_symlink("/proc/self/exe", error); !error) {
    places.push_back(program.parent_path() / file);
    places.push_back(program.parent_path().parent_path() / "lib" / "skein" / "modules" / file);
  }
#ifdef SKEIN_MODULE_BUILD_FOLDER
  places.push_back(fs::path(SKEIN_MODULE_BUILD_FOLDER) / file);
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
    if (const void* symbol = dlsym(module, symbol_name)) return symbol;
    tried += "of another version";
  }
  return tl::unexpected(fmt::format("the module {} cannot be loaded:{}", file, tried));
}

}  // namespace

tl::expected<const Media*, std::string> media() {
  static const auto loaded = load("skein_media.so", media_symbol);
  if (!loaded) return tl::unexpected("pictures, videos and MJPEG cameras: " + loaded.error());
  return static_cast<const Media*>(*loaded);
}

tl::expected<const Boards*, std::string> boards() {
  static const auto loaded = load("skein_boards.so", boards_symbol);
  if (!loaded) return tl::unexpected("calibration boards and printed sheets: " + loaded.error());
  return static_cast<const Boards*>(*loaded);
}

tl::expected<const Aravis*, std::string> aravis() {
  static const auto loaded = load("skein_aravis.so", aravis_symbol);
  if (!loaded) return tl::unexpected("GigE and USB3 Vision cameras: " + loaded.error());
  return static_cast<const Aravis*>(*loaded);
}

}  // namespace skein::vision
