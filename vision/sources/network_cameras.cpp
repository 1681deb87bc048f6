#include "vision/sources/network_cameras.h"

#include "vision/modules/media_loader.h"

namespace skein::vision {

tl::expected<std::vector<NetworkCamera>, std::string> network_cameras() {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  return (*module)->discover();
}

tl::expected<std::vector<std::string>, std::string> describe_network_camera(const std::string& camera) {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  std::string error;
  std::vector<std::string> lines = (*module)->describe(camera, error);
  if (!error.empty()) return tl::unexpected(error);
  return lines;
}

}  // namespace skein::vision
