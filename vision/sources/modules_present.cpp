#include "vision/sources/modules_present.h"

#include "vision/modules/media_loader.h"

namespace skein::vision {

tl::expected<void, std::string> modules_present() {
  if (const auto loaded = media(); !loaded) return tl::unexpected(loaded.error());
  if (const auto loaded = boards(); !loaded) return tl::unexpected(loaded.error());
  if (const auto loaded = aravis(); !loaded) return tl::unexpected(loaded.error());
  return {};
}

}  // namespace skein::vision
