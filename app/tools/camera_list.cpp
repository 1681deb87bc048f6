#include "app/tools/camera_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>

#include "app/tools/aside.h"
#include "vision/sources/network_cameras.h"
#include "vision/v4l2/camera_controls.h"

namespace skein::app {

FoundCameras find_cameras() {
  FoundCameras found;
  std::vector<std::string> devices;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error))
    if (entry.path().filename().string().starts_with("video")) devices.push_back(entry.path().string());
  std::sort(devices.begin(), devices.end());
  for (const std::string& device : devices)
    if (const auto camera = vision::describe_camera(device))
      found.cameras.push_back({"v4l2:" + device, fmt::format("{} ({})", camera->card, camera->driver)});
  const auto answering = vision::network_cameras();
  if (!answering) {
    found.problem = answering.error();
    return found;
  }
  for (const vision::NetworkCamera& camera : *answering)
    found.cameras.push_back(
        {"aravis:" + camera.name, fmt::format("{} ({}, {})", camera.model, camera.protocol, camera.address)});
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
