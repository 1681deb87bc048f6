#include "vision/sources/open_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "vision/modules/media_loader.h"
#include "vision/v4l2/camera_controls.h"
#include "vision/v4l2/v4l2_source.h"

namespace skein::vision {
namespace {

using Opened = tl::expected<std::unique_ptr<FrameSource>, std::string>;

Opened open_media(MediaKind kind, const std::string& path) {
  const auto module = media();
  if (!module) return tl::unexpected(module.error());
  std::string error;
  auto opened = (*module)->open(kind, path, error);
  if (!opened) return tl::unexpected(error);
  return opened;
}

Opened open_images(const std::string& path, const SourceOptions& /*options*/) {
  return open_media(MediaKind::images, path);
}
Opened open_video(const std::string& path, const SourceOptions& /*options*/) {
  return open_media(MediaKind::video, path);
}
Opened open_camera(const std::string& device, const SourceOptions& options) {
  return open_v4l2(device, options);
}
tl::expected<CameraSettings, std::string> settings_of_camera(const std::string& device, const ControlSettings& set) {
  return v4l2_settings(device, set);
}
Opened open_aravis(const std::string& camera, const SourceOptions& options) {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  std::string error;
  auto opened = (*module)->open(camera, options, error);
  if (!opened) return tl::unexpected(error);
  return opened;
}
tl::expected<std::vector<ConnectedCamera>, std::string> connected_devices() {
  std::vector<std::string> devices;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error))
    if (entry.path().filename().string().starts_with("video")) devices.push_back(entry.path().string());
  std::sort(devices.begin(), devices.end());
  std::vector<ConnectedCamera> cameras;
  for (const std::string& device : devices)
    if (const auto camera = describe_camera(device))
      cameras.push_back({.where = device, .what = fmt::format("{} ({})", camera->card, camera->driver)});
  return cameras;
}
tl::expected<std::vector<std::string>, std::string> describe_device(const std::string& device) {
  const auto camera = describe_camera(device);
  if (!camera) return tl::unexpected(camera.error());
  std::vector<std::string> lines{fmt::format("{}: {} ({})", device, camera->card, camera->driver), "formats:"};
  for (const CameraFormat& format : camera->formats) lines.push_back("  " + to_text(format));
  lines.emplace_back("controls:");
  for (const CameraControl& control : camera->controls) lines.push_back("  " + to_text(control));
  return lines;
}
tl::expected<CameraSettings, std::string> settings_of_aravis(const std::string& camera, const ControlSettings& set) {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  std::string error;
  CameraSettings settings = (*module)->settings(camera, set, error);
  if (!error.empty()) return tl::unexpected(error);
  return settings;
}

tl::expected<std::vector<ConnectedCamera>, std::string> connected_to_aravis() {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  std::vector<ConnectedCamera> cameras;
  for (const NetworkCamera& camera : (*module)->discover())
    cameras.push_back({.where = camera.name,
                       .also = camera.address,
                       .what = fmt::format("{} ({}, {})", camera.model, camera.protocol, camera.address)});
  return cameras;
}
tl::expected<std::vector<std::string>, std::string> describe_aravis(const std::string& camera) {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  std::string error;
  std::vector<std::string> lines = (*module)->describe(camera, error);
  if (!error.empty()) return tl::unexpected(error);
  return lines;
}

constexpr std::array kinds{
    SourceKind{.name = "images",
               .where = "DIR",
               .what = "a folder of pictures",
               .connection = Connection::file,
               .open = open_images},
    SourceKind{.name = "video", .where = "FILE", .what = "a film", .connection = Connection::file, .open = open_video},
    SourceKind{.name = "v4l2",
               .where = "DEVICE",
               .what = "a camera of the kernel",
               .connection = Connection::device,
               .open = open_camera,
               .settings = settings_of_camera,
               .connected = connected_devices,
               .describe = describe_device,
               .settable_while_read = true},
    SourceKind{.name = "aravis",
               .where = "CAMERA",
               .what = "a GigE Vision or USB3 Vision camera",
               .connection = Connection::network,
               .open = open_aravis,
               .settings = settings_of_aravis,
               .connected = connected_to_aravis,
               .describe = describe_aravis,
               .triggers = true},
};

static_assert(std::ranges::all_of(kinds,
                                  [](const SourceKind& kind) {
                                    const bool camera = kind.connection != Connection::file;
                                    return camera == (kind.settings != nullptr) &&
                                           camera == (kind.connected != nullptr) &&
                                           camera == (kind.describe != nullptr);
                                  }),
              "a camera can be set, found and described; films and pictures cannot");

/// "KIND:WHERE" of the kinds that `wanted` selects, separated by commas.
template <typename Wanted>
std::string forms_of(const Wanted& wanted) {
  std::string forms;
  for (const SourceKind& kind : kinds)
    if (wanted(kind)) forms += fmt::format("{}{}:{}", forms.empty() ? "" : ", ", kind.name, kind.where);
  return forms;
}

}  // namespace

std::span<const SourceKind> source_kinds() {
  return kinds;
}

tl::expected<SourceAddress, std::string> parse_source(std::string_view address) {
  const std::size_t colon = address.find(':');
  const std::string_view name = address.substr(0, colon);
  const auto kind = std::find_if(kinds.begin(), kinds.end(), [&](const SourceKind& k) { return k.name == name; });
  if (kind == kinds.end() || colon == std::string_view::npos || colon + 1 == address.size())
    return tl::unexpected(
        fmt::format("source \"{}\"; allowed: {} (such as v4l2:/dev/video0)", address, source_forms()));
  return SourceAddress{&*kind, std::string(address.substr(colon + 1))};
}

bool is_camera(std::string_view address) {
  const auto parsed = parse_source(address);
  return parsed && parsed->live();
}

std::string source_forms() {
  return forms_of([](const SourceKind&) { return true; });
}

std::string camera_forms() {
  return forms_of([](const SourceKind& kind) { return kind.connection != Connection::file; });
}

tl::expected<std::unique_ptr<FrameSource>, std::string> open_source(std::string_view address,
                                                                    const SourceOptions& options) {
  const auto parsed = parse_source(address);
  if (!parsed) return tl::unexpected(parsed.error());
  if (!options.trigger.empty() && !parsed->kind->triggers)
    return tl::unexpected(fmt::format("{}: trigger \"{}\"; only cameras of the kind {} can be triggered", address,
                                      options.trigger, forms_of([](const SourceKind& kind) { return kind.triggers; })));
  return parsed->kind->open(parsed->where, options);
}

tl::expected<CameraSettings, std::string> camera_settings(std::string_view address, const ControlSettings& set) {
  const auto parsed = parse_source(address);
  if (!parsed) return tl::unexpected(parsed.error());
  if (!parsed->kind->settings)
    return tl::unexpected(fmt::format("{} is not a camera; allowed: {}", address, camera_forms()));
  return parsed->kind->settings(parsed->where, set);
}

bool settable_while_read(std::string_view address) {
  const auto parsed = parse_source(address);
  return parsed && parsed->kind->settable_while_read;
}

}  // namespace skein::vision
