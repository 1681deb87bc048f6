#include "vision/frame_source.h"

#include <fmt/format.h>

#include "vision/media_loader.h"
#include "vision/v4l2_source.h"

namespace skein::vision {

tl::expected<std::unique_ptr<FrameSource>, std::string> open_source(std::string_view source,
                                                                    const SourceOptions& options) {
  const std::size_t colon = source.find(':');
  const std::string_view kind = source.substr(0, colon);
  const std::string path(colon == std::string_view::npos ? std::string_view{} : source.substr(colon + 1));
  if ((kind != "images" && kind != "video" && kind != "v4l2") || path.empty()) {
    return tl::unexpected(
        fmt::format("source \"{}\"; allowed: images:DIR, video:FILE, v4l2:DEVICE (such as v4l2:/dev/video0)", source));
  }
  if (kind == "v4l2") return open_v4l2(path, options);

  const auto module = media();
  if (!module) return tl::unexpected(module.error());
  std::string error;
  auto opened = (*module)->open(kind == "video" ? MediaKind::video : MediaKind::images, path, error);
  if (!opened) return tl::unexpected(error);
  return opened;
}

}  // namespace skein::vision
