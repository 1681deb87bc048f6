#include "app/tools/camera_list.h"

#include <fmt/format.h>

#include <exception>
#include <memory>

#include "app/tools/aside.h"
#include "vision/sources/open_source.h"

namespace skein::app {

FoundCameras find_cameras() {
  FoundCameras found;
  for (const vision::SourceKind& kind : vision::source_kinds()) {
    if (!kind.connected) continue;
    const auto connected = kind.connected();
    if (!connected) {
      found.problem = connected.error();
      continue;
    }
    for (const vision::ConnectedCamera& camera : *connected)
      found.cameras.push_back({fmt::format("{}:{}", kind.name, camera.where), camera.what});
  }
  return found;
}

std::future<FoundCameras> find_cameras_aside() {
  const auto promise = std::make_shared<std::promise<FoundCameras>>();
  std::future<FoundCameras> found = promise->get_future();
  run_aside([promise] {
    try {
      promise->set_value(find_cameras());
    } catch (const std::exception& error) {
      promise->set_value({{}, error.what()});
    }
  });
  return found;
}

}  // namespace skein::app
