#include "vision/sources/open_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

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
tl::expected<CameraSettings, std::string> settings_of_aravis(const std::string& camera, const ControlSettings& set) {
  const auto module = aravis();
  if (!module) return tl::unexpected(module.error());
  std::string error;
  CameraSettings settings = (*module)->settings(camera, set, error);
  if (!error.empty()) return tl::unexpected(error);
  return settings;
}

constexpr std::array kinds{
    SourceKind{"images", "DIR", false, false, open_images, nullptr, false},
    SourceKind{"video", "FILE", false, false, open_video, nullptr, false},
    SourceKind{"v4l2", "DEVICE", true, false, open_camera, settings_of_camera, true},
    SourceKind{"aravis", "CAMERA", true, true, open_aravis, settings_of_aravis, false},
};

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
  std::string forms;
  for (const SourceKind& kind : kinds)
    forms += fmt::format("{}{}:{}", forms.empty() ? "" : ", ", kind.name, kind.where);
  return forms;
}

tl::expected<std::unique_ptr<FrameSource>, std::string> open_source(std::string_view address,
                                                                    const SourceOptions& options) {
  const auto parsed = parse_source(address);
  if (!parsed) return tl::unexpected(parsed.error());
  if (!options.trigger.empty() && !parsed->kind->triggers)
    return tl::unexpected(fmt::format("{}: trigger \"{}\"; only cameras of the kind aravis:CAMERA can be triggered",
                                      address, options.trigger));
  return parsed->kind->open(parsed->where, options);
}

tl::expected<CameraSettings, std::string> camera_settings(std::string_view address, const ControlSettings& set) {
  const auto parsed = parse_source(address);
  if (!parsed) return tl::unexpected(parsed.error());
  if (!parsed->kind->settings)
    return tl::unexpected(fmt::format("{} is not a camera; allowed: v4l2:DEVICE, aravis:CAMERA", address));
  return parsed->kind->settings(parsed->where, set);
}

bool settable_while_read(std::string_view address) {
  const auto parsed = parse_source(address);
  return parsed && parsed->kind->settable_while_read;
}

}  // namespace skein::vision
