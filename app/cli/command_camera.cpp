#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "vision/sources/network_cameras.h"
#include "vision/v4l2/camera_controls.h"

namespace skein::app {
namespace {

std::string text_of(const vision::CameraControl& control) {
  std::string text = fmt::format("  {} = {}", control.name, control.value);
  if (control.choices.empty()) {
    text += fmt::format("  ({} to {}", control.least, control.most);
    if (control.step != 1) text += fmt::format(" in steps of {}", control.step);
  } else {
    std::vector<std::string> choices;
    for (const auto& [value, name] : control.choices) choices.push_back(fmt::format("{}: {}", value, name));
    text += fmt::format("  ({}", fmt::join(choices, ", "));
  }
  return text + fmt::format("; default {}{})", control.standard, control.settable ? "" : "; cannot be set now");
}

constexpr std::string_view of_aravis = "aravis:", of_v4l2 = "v4l2:";

int list_aravis(const std::string& name) {
  const auto lines = vision::describe_network_camera(name);
  if (!lines) {
    complain(lines.error());
    return device_failed;
  }
  fmt::print("{}\n", fmt::join(*lines, "\n"));
  return done;
}

/// Prints those that answer; how many, or why nobody could be asked.
tl::expected<int, std::string> list_aravis_cameras() {
  const auto cameras = vision::network_cameras();
  if (!cameras) return tl::unexpected(cameras.error());
  for (const vision::NetworkCamera& camera : *cameras)
    fmt::print("aravis:{}: {} ({}, {})\n", camera.name, camera.model, camera.protocol, camera.address);
  return static_cast<int>(cameras->size());
}

int list_one(const std::string& device) {
  const auto camera = vision::describe_camera(device);
  if (!camera) {
    complain(camera.error());
    return device_failed;
  }
  fmt::print("{}: {} ({})\nformats:\n", device, camera->card, camera->driver);
  for (const vision::CameraFormat& format : camera->formats) {
    std::vector<std::string> rates;
    for (const double rate : format.rates) rates.push_back(fmt::format("{:.4g}", rate));
    fmt::print("  {} {}x{}{}{}\n", format.format, format.width, format.height,
               rates.empty() ? "" : ", frames/s: ", fmt::join(rates, " "));
  }
  fmt::print("controls:\n");
  for (const vision::CameraControl& control : camera->controls) fmt::print("{}\n", text_of(control));
  return done;
}

}  // namespace

int list_cameras(const std::string& camera) {
  if (camera.starts_with(of_aravis)) return list_aravis(camera.substr(of_aravis.size()));
  if (camera.starts_with(of_v4l2)) return list_one(camera.substr(of_v4l2.size()));
  if (!camera.empty()) return list_one(camera);
  std::vector<std::string> devices;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error))
    if (entry.path().filename().string().starts_with("video")) devices.push_back(entry.path().string());
  std::sort(devices.begin(), devices.end());
  int cameras = 0;
  for (const std::string& name : devices)
    if (const auto found = vision::describe_camera(name)) {
      fmt::print("v4l2:{}: {} ({})\n", name, found->card, found->driver);
      ++cameras;
    }
  const auto in_the_network = list_aravis_cameras();
  if (!in_the_network) complain(in_the_network.error());
  if (cameras + in_the_network.value_or(0) > 0) return done;
  print_error("skein: no camera at /dev/video*, and none of GigE or USB3 Vision that answers\n");
  return device_failed;
}

}  // namespace skein::app
