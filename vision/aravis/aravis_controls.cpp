#include "vision/aravis/aravis_controls.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <cmath>
#include <mutex>

#include "vision/aravis/genicam.h"

namespace skein::vision::detail {
namespace {

constexpr double micro = 1e-6;

struct Range {
  double least = 0.0, most = 0.0;
  bool holds(double value) const { return value >= least && value <= most; }
};

bool has(ArvCamera* camera, const char* feature, Silence& silence) {
  return arv_camera_is_feature_available(camera, feature, &silence) != FALSE;
}

Range exposure_range(ArvCamera* camera, Silence& silence) {
  Range us;
  arv_camera_get_exposure_time_bounds(camera, &us.least, &us.most, &silence);
  return {micro * us.least, micro * us.most};
}
Range gain_range(ArvCamera* camera, Silence& silence) {
  Range range;
  arv_camera_get_gain_bounds(camera, &range.least, &range.most, &silence);
  return range;
}

/// The network address of a GigE camera's name, as it is now: opened by that, Aravis streams through the interface that
/// leads there, not through whichever heard the camera first. Other names and addresses as they are.
std::string address_of(const std::string& name) {
  if (in_addr ip{}; ::inet_pton(AF_INET, name.c_str(), &ip) == 1) return name;
  for (const NetworkCamera& camera : discover())
    if (camera.name == name && camera.protocol == "GigEVision") return camera.address;
  return name;
}

std::string not_allowed(const std::string& camera, const std::string& name, double value, const Range& range) {
  return fmt::format("aravis:{}: {} = {}; allowed: {:.6g} to {:.6g}", camera, name, value, range.least, range.most);
}

/// A control as it is set and read back. `problem`: why it cannot be.
struct Written {
  double value = 0.0;
  std::string problem{};
};

Written write_exposure(ArvCamera* camera, const std::string& name, double seconds, Silence& silence) {
  Failure failed;
  if (!arv_camera_is_exposure_time_available(camera, &silence))
    return {0.0, fmt::format("aravis:{}: has no control exposure", name)};
  if (arv_camera_is_exposure_auto_available(camera, &silence))
    arv_camera_set_exposure_time_auto(camera, seconds == 0.0 ? ARV_AUTO_CONTINUOUS : ARV_AUTO_OFF, &failed);
  else if (seconds == 0.0)
    return {0.0, fmt::format("aravis:{}: exposure = 0; the camera has no automatic exposure", name)};
  if (failed) return {0.0, fmt::format("aravis:{}: exposure: {}", name, failed.text())};
  if (seconds == 0.0) return {};
  if (const Range range = exposure_range(camera, silence); !range.holds(seconds))
    return {0.0, not_allowed(name, "exposure", seconds, range)};
  arv_camera_set_exposure_time(camera, seconds / micro, &failed);
  if (failed) return {0.0, fmt::format("aravis:{}: exposure = {}: {}", name, seconds, failed.text())};
  return {micro * arv_camera_get_exposure_time(camera, &silence)};
}

Written write_gain(ArvCamera* camera, const std::string& name, double gain, Silence& silence) {
  Failure failed;
  if (!arv_camera_is_gain_available(camera, &silence))
    return {0.0, fmt::format("aravis:{}: has no control gain", name)};
  if (arv_camera_is_gain_auto_available(camera, &silence)) arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, &failed);
  if (const Range range = gain_range(camera, silence); !range.holds(gain))
    return {0.0, not_allowed(name, "gain", gain, range)};
  arv_camera_set_gain(camera, gain, &failed);
  if (failed) return {0.0, fmt::format("aravis:{}: gain = {}: {}", name, gain, failed.text())};
  return {arv_camera_get_gain(camera, &silence)};
}

/// Any feature of the camera that has a number.
Written write_feature(ArvCamera* camera, const std::string& name, const std::string& feature, double value,
                      Silence& silence) {
  const char* const key = feature.c_str();
  ArvGcNode* node = arv_device_get_feature(arv_camera_get_device(camera), key);
  if (node == nullptr || !has(camera, key, silence))
    return {0.0, fmt::format("aravis:{}: has no control {} (exposure, gain, or a GenICam feature)", name, feature)};
  Failure failed;
  Written written;
  if (ARV_IS_GC_BOOLEAN(node)) {
    if (value != 0.0 && value != 1.0) return {0.0, not_allowed(name, feature, value, {0.0, 1.0})};
    arv_camera_set_boolean(camera, key, value != 0.0, &failed);
    if (!failed) written.value = arv_camera_get_boolean(camera, key, &failed) ? 1.0 : 0.0;
  } else if (ARV_IS_GC_FLOAT(node)) {
    Range range;
    arv_camera_get_float_bounds(camera, key, &range.least, &range.most, &silence);
    if (!range.holds(value)) return {0.0, not_allowed(name, feature, value, range)};
    arv_camera_set_float(camera, key, value, &failed);
    if (!failed) written.value = arv_camera_get_float(camera, key, &failed);
  } else if (ARV_IS_GC_INTEGER(node)) {  // menus too
    gint64 least = 0;
    gint64 most = 0;
    if (!ARV_IS_GC_ENUMERATION(node)) {
      arv_camera_get_integer_bounds(camera, key, &least, &most, &silence);
      const Range range{static_cast<double>(least), static_cast<double>(most)};
      if (value != std::round(value) || !range.holds(value)) return {0.0, not_allowed(name, feature, value, range)};
    }
    arv_camera_set_integer(camera, key, static_cast<gint64>(value), &failed);
    if (!failed) written.value = static_cast<double>(arv_camera_get_integer(camera, key, &failed));
  } else {
    return {0.0, fmt::format("aravis:{}: {} is no number", name, feature)};
  }
  if (failed) written.problem = fmt::format("aravis:{}: {} = {}: {}", name, feature, value, failed.text());
  return written;
}

bool asked(const ControlSettings& settings, const char* name) {
  for (const auto& [each, value] : settings)
    if (each == name) return true;
  return false;
}

}  // namespace

std::vector<NetworkCamera> discover() {
  // Aravis returns pointers into its list of devices, and every search frees the list of the search before.
  static std::mutex searching;
  const std::lock_guard lock(searching);
  arv_update_device_list();
  std::vector<NetworkCamera> cameras;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i)
    cameras.push_back({text(arv_get_device_id(i)), text(arv_get_device_vendor(i)) + " " + text(arv_get_device_model(i)),
                       text(arv_get_device_address(i)), text(arv_get_device_protocol(i))});
  return cameras;
}

Object<ArvCamera> open_named(const std::string& name, Failure& failed) {
  return Object<ArvCamera>(arv_camera_new(address_of(name).c_str(), &failed));
}

std::string set_controls(ArvCamera* camera, const std::string& name, const ControlSettings& settings,
                         std::vector<std::string>& notices) {
  Silence silence;
  for (const auto& [control, value] : settings) {
    const Written written = control == "exposure" ? write_exposure(camera, name, value, silence)
                            : control == "gain"   ? write_gain(camera, name, value, silence)
                                                  : write_feature(camera, name, control, value, silence);
    if (const std::string why = silence.text(); !why.empty())
      return fmt::format("aravis:{}: {} = {}: {}", name, control, value, why);
    if (!written.problem.empty()) return written.problem;
    const bool automatic = control == "exposure" && value == 0.0;
    // Steps of a shutter are parts of a microsecond to some; what differs by less than a part in a thousand is as
    // asked.
    if (!automatic && std::abs(written.value - value) > 1e-3 * std::abs(value))
      notices.push_back(fmt::format("aravis:{}: {} is {:.6g}, not {}", name, control, written.value, value));
  }
  for (const std::string& automatic : automatics_on(camera, settings))
    notices.push_back(fmt::format("aravis:{}: its {} is automatic, and so {}", name, automatic,
                                  automatic == "exposure" ? "are blur and time of capture" : "is its noise"));
  return {};
}

std::vector<std::string> automatics_on(ArvCamera* camera, const ControlSettings& settings) {
  Silence silence;
  std::vector<std::string> names;
  if (!asked(settings, "exposure") && arv_camera_is_exposure_auto_available(camera, &silence) &&
      arv_camera_get_exposure_time_auto(camera, &silence) != ARV_AUTO_OFF)
    names.emplace_back("exposure");
  if (!asked(settings, "gain") && arv_camera_is_gain_auto_available(camera, &silence) &&
      arv_camera_get_gain_auto(camera, &silence) != ARV_AUTO_OFF)
    names.emplace_back("gain");
  return names;
}

std::vector<std::string> words_of(ArvCamera* camera, const char* feature, Silence& silence) {
  guint count = 0;
  const std::unique_ptr<const char*, Free> words(
      arv_camera_dup_available_enumerations_as_strings(camera, feature, &count, &silence));
  return words ? std::vector<std::string>(words.get(), words.get() + count) : std::vector<std::string>();
}

ClockFeatures clock_features(ArvCamera* camera, Silence& silence) {
  if (has(camera, "TimestampLatch", silence) && has(camera, "TimestampLatchValue", silence))
    return {"TimestampLatch", "TimestampLatchValue", 1e9};
  if (has(camera, "GevTimestampControlLatch", silence) && has(camera, "GevTimestampValue", silence)) {
    const auto frequency = static_cast<double>(arv_camera_get_integer(camera, "GevTimestampTickFrequency", &silence));
    if (frequency > 0.0) return {"GevTimestampControlLatch", "GevTimestampValue", frequency};
  }
  return {};
}

std::vector<CameraSetting> settings_of(ArvCamera* camera, Silence& silence) {
  std::vector<CameraSetting> settings;
  if (arv_camera_is_exposure_time_available(camera, &silence)) {
    const Range range = exposure_range(camera, silence);
    settings.push_back({.name = "exposure",
                        .value = micro * arv_camera_get_exposure_time(camera, &silence),
                        .least = range.least,
                        .most = range.most,
                        .automatic = arv_camera_is_exposure_auto_available(camera, &silence) &&
                                     arv_camera_get_exposure_time_auto(camera, &silence) != ARV_AUTO_OFF});
  }
  if (arv_camera_is_gain_available(camera, &silence)) {
    const Range range = gain_range(camera, silence);
    settings.push_back({.name = "gain",
                        .value = arv_camera_get_gain(camera, &silence),
                        .least = range.least,
                        .most = range.most,
                        .automatic = arv_camera_is_gain_auto_available(camera, &silence) &&
                                     arv_camera_get_gain_auto(camera, &silence) != ARV_AUTO_OFF});
  }
  return settings;
}

std::vector<std::string> describe(ArvCamera* camera, Silence& silence) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{} {}, serial number {}", text(arv_camera_get_vendor_name(camera, &silence)),
                              text(arv_camera_get_model_name(camera, &silence)),
                              text(arv_camera_get_device_serial_number(camera, &silence))));
  gint x = 0;
  gint y = 0;
  gint width = 0;
  gint height = 0;
  arv_camera_get_sensor_size(camera, &width, &height, &silence);
  lines.push_back(fmt::format("sensor: {}x{}", width, height));
  arv_camera_get_region(camera, &x, &y, &width, &height, &silence);
  lines.push_back(fmt::format("frames: {}x{} at ({}, {}), {}", width, height, x, y,
                              text(arv_camera_get_pixel_format_as_string(camera, &silence))));
  lines.push_back(fmt::format("formats: {}", fmt::join(words_of(camera, "PixelFormat", silence), " ")));
  if (arv_camera_is_frame_rate_available(camera, &silence)) {
    Range range;
    arv_camera_get_frame_rate_bounds(camera, &range.least, &range.most, &silence);
    lines.push_back(fmt::format("frames/s: {:.4g} ({:.4g} to {:.4g})", arv_camera_get_frame_rate(camera, &silence),
                                range.least, range.most));
  }
  for (const CameraSetting& setting : settings_of(camera, silence))
    lines.push_back(fmt::format("{}: {:.4g}{} ({:.4g} to {:.4g})", setting.name, setting.value,
                                setting.name == "exposure" ? " s" : "", setting.least, setting.most));
  std::string triggers = fmt::format("{}", fmt::join(words_of(camera, "TriggerSource", silence), " "));
  lines.push_back(fmt::format("triggers: {}", triggers.empty() ? "none" : triggers));
  const ClockFeatures clock = clock_features(camera, silence);
  lines.push_back(fmt::format("clock: {}", clock.latch != nullptr ? clock.latch : "cannot be read"));
  return lines;
}

}  // namespace skein::vision::detail
