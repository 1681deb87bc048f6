#include "vision/sources/network_cameras.h"

#include "vision/modules/media_loader.h"

namespace skein::vision {

tl::expected<std::vector<NetworkCamera>, std::string> network_cameras() {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  std::vector<NetworkCamera> cameras;
  for (AravisCamera& found : (*module)->discover())
    cameras.push_back(
        {std::move(found.name), std::move(found.model), std::move(found.address), std::move(found.protocol)});
  return cameras;
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
