#include "vision/aravis/aravis_controls.h"
#include "vision/aravis/aravis_source.h"
#include "vision/aravis/genicam.h"

namespace skein::vision::detail {
namespace {

std::string no_answer(const std::string& name, const std::string& why) {
  return "aravis:" + name + ": " + why;
}

std::vector<std::string> describe_camera(const std::string& name, std::string& error) {
  Failure failed;
  const Object<ArvCamera> camera = open_named(name, failed);
  Silence silence;
  std::vector<std::string> lines;
  if (camera) lines = describe(camera.get(), silence);
  if (camera && silence.text().empty()) return lines;
  error = no_answer(name, camera ? silence.text() : failed.text());
  return {};
}

CameraSettings set_and_read(const std::string& name, const ControlSettings& set, std::string& error) {
  Failure failed;
  const Object<ArvCamera> camera = open_named(name, failed);
  if (!camera) {
    error = no_answer(name, failed.text());
    return {};
  }
  CameraSettings settings;
  error = set_controls(camera.get(), name, set, settings.notices);
  Silence silence;
  settings.all = settings_of(camera.get(), silence);
  if (error.empty() && !silence.text().empty()) error = no_answer(name, silence.text());
  return settings;
}

}  // namespace
}  // namespace skein::vision::detail

extern "C" __attribute__((visibility("default")))
const skein::vision::Aravis skein_aravis_4 = {.open = skein::vision::detail::open_camera,
                                              .discover = skein::vision::detail::discover,
                                              .describe = skein::vision::detail::describe_camera,
                                              .settings = skein::vision::detail::set_and_read};
