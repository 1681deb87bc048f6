#include "vision/aravis/aravis_controls.h"

#include <fmt/format.h>

#include <cmath>

#include "vision/aravis/genicam.h"

namespace skein::vision::detail {
namespace {

constexpr double micro = 1e-6;

struct Range {
  double least = 0.0, most = 0.0;
  bool holds(double value) const { return value >= least && value <= most; }
};

bool has(ArvCamera* camera, const char* feature) {
  return arv_camera_is_feature_available(camera, feature, nullptr) != FALSE;
}

Range exposure_range(ArvCamera* camera) {
  Range us;
  arv_camera_get_exposure_time_bounds(camera, &us.least, &us.most, nullptr);
  return {micro * us.least, micro * us.most};
}
Range gain_range(ArvCamera* camera) {
  Range range;
  arv_camera_get_gain_bounds(camera, &range.least, &range.most, nullptr);
  return range;
}

std::string not_allowed(const std::string& camera, const std::string& name, double value, const Range& range) {
  return fmt::format("aravis:{}: {} = {}; allowed: {:.6g} to {:.6g}", camera, name, value, range.least, range.most);
}

/// A control as it is set and read back. `problem`: why it cannot be.
struct Written {
  double value = 0.0;
  std::string problem{};
};

Written write_exposure(ArvCamera* camera, const std::string& name, double seconds) {
  Failure failed;
  if (!arv_camera_is_exposure_time_available(camera, &failed))
    return {0.0, fmt::format("aravis:{}: has no control exposure", name)};
  if (arv_camera_is_exposure_auto_available(camera, nullptr))
    arv_camera_set_exposure_time_auto(camera, seconds == 0.0 ? ARV_AUTO_CONTINUOUS : ARV_AUTO_OFF, &failed);
  else if (seconds == 0.0)
    return {0.0, fmt::format("aravis:{}: exposure = 0; the camera has no automatic exposure", name)};
  if (failed) return {0.0, fmt::format("aravis:{}: exposure: {}", name, failed.text())};
  if (seconds == 0.0) return {};
  if (const Range range = exposure_range(camera); !range.holds(seconds))
    return {0.0, not_allowed(name, "exposure", seconds, range)};
  arv_camera_set_exposure_time(camera, seconds / micro, &failed);
  if (failed) return {0.0, fmt::format("aravis:{}: exposure = {}: {}", name, seconds, failed.text())};
  return {micro * arv_camera_get_exposure_time(camera, nullptr)};
}

Written write_gain(ArvCamera* camera, const std::string& name, double gain) {
  Failure failed;
  if (!arv_camera_is_gain_available(camera, &failed)) return {0.0, fmt::format("aravis:{}: has no control gain", name)};
  if (arv_camera_is_gain_auto_available(camera, nullptr)) arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, &failed);
  if (const Range range = gain_range(camera); !range.holds(gain)) return {0.0, not_allowed(name, "gain", gain, range)};
  arv_camera_set_gain(camera, gain, &failed);
  if (failed) return {0.0, fmt::format("aravis:{}: gain = {}: {}", name, gain, failed.text())};
  return {arv_camera_get_gain(camera, nullptr)};
}

/// Any feature of the camera that has a number.
Written write_feature(ArvCamera* camera, const std::string& name, const std::string& feature, double value) {
  const char* const key = feature.c_str();
  ArvGcNode* node = arv_device_get_feature(arv_camera_get_device(camera), key);
  if (node == nullptr || !has(camera, key))
    return {0.0, fmt::format("aravis:{}: has no control {} (exposure, gain, or a GenICam feature)", name, feature)};
  Failure failed;
  Written written;
  if (ARV_IS_GC_BOOLEAN(node)) {
    if (value != 0.0 && value != 1.0) return {0.0, not_allowed(name, feature, value, {0.0, 1.0})};
    arv_camera_set_boolean(camera, key, value != 0.0, &failed);
    if (!failed) written.value = arv_camera_get_boolean(camera, key, &failed) ? 1.0 : 0.0;
  } else if (ARV_IS_GC_FLOAT(node)) {
    Range range;
    arv_camera_get_float_bounds(camera, key, &range.least, &range.most, nullptr);
    if (!range.holds(value)) return {0.0, not_allowed(name, feature, value, range)};
    arv_camera_set_float(camera, key, value, &failed);
    if (!failed) written.value = arv_camera_get_float(camera, key, &failed);
  } else if (ARV_IS_GC_INTEGER(node)) {  // menus too
    gint64 least = 0;
    gint64 most = 0;
    if (!ARV_IS_GC_ENUMERATION(node)) {
      arv_camera_get_integer_bounds(camera, key, &least, &most, nullptr);
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

std::string set_controls(ArvCamera* camera, const std::string& name, const ControlSettings& settings,
                         std::vector<std::string>& notices) {
  for (const auto& [control, value] : settings) {
    const Written written = control == "exposure" ? write_exposure(camera, name, value)
                            : control == "gain"   ? write_gain(camera, name, value)
                                                  : write_feature(camera, name, control, value);
    if (!written.problem.empty()) return written.problem;
    const bool automatic = control == "exposure" && value == 0.0;
    // Steps of a shutter are parts of a microsecond to some; what differs by less than a part in a thousand is as
    // asked.
    if (!automatic && std::abs(written.value - value) > 1e-3 * std::abs(value))
      notices.push_back(fmt::format("aravis:{}: {} is {:.6g}, not {}", name, control, written.value, value));
  }
  if (!asked(settings, "exposure") && arv_camera_is_exposure_auto_available(camera, nullptr) &&
      arv_camera_get_exposure_time_auto(camera, nullptr) != ARV_AUTO_OFF)
    notices.push_back(fmt::format("aravis:{}: its exposure is automatic, and so are blur and time of capture", name));
  if (!asked(settings, "gain") && arv_camera_is_gain_auto_available(camera, nullptr) &&
      arv_camera_get_gain_auto(camera, nullptr) != ARV_AUTO_OFF)
    notices.push_back(fmt::format("aravis:{}: its gain is automatic, and so is its noise", name));
  return {};
}

std::vector<std::string> words_of(ArvCamera* camera, const char* feature) {
  guint count = 0;
  const std::unique_ptr<const char*, Free> words(
      arv_camera_dup_available_enumerations_as_strings(camera, feature, &count, nullptr));
  return words ? std::vector<std::string>(words.get(), words.get() + count) : std::vector<std::string>();
}

ClockFeatures clock_features(ArvCamera* camera) {
  if (has(camera, "TimestampLatch") && has(camera, "TimestampLatchValue"))
    return {"TimestampLatch", "TimestampLatchValue", 1e9};
  if (has(camera, "GevTimestampControlLatch") && has(camera, "GevTimestampValue")) {
    const auto frequency = static_cast<double>(arv_camera_get_integer(camera, "GevTimestampTickFrequency", nullptr));
    if (frequency > 0.0) return {"GevTimestampControlLatch", "GevTimestampValue", frequency};
  }
  return {};
}

std::vector<CameraSetting> settings_of(ArvCamera* camera) {
  std::vector<CameraSetting> settings;
  if (arv_camera_is_exposure_time_available(camera, nullptr)) {
    const Range range = exposure_range(camera);
    settings.push_back({.name = "exposure",
                        .value = micro * arv_camera_get_exposure_time(camera, nullptr),
                        .least = range.least,
                        .most = range.most,
                        .automatic = arv_camera_is_exposure_auto_available(camera, nullptr) &&
                                     arv_camera_get_exposure_time_auto(camera, nullptr) != ARV_AUTO_OFF});
  }
  if (arv_camera_is_gain_available(camera, nullptr)) {
    const Range range = gain_range(camera);
    settings.push_back({.name = "gain",
                        .value = arv_camera_get_gain(camera, nullptr),
                        .least = range.least,
                        .most = range.most,
                        .automatic = arv_camera_is_gain_auto_available(camera, nullptr) &&
                                     arv_camera_get_gain_auto(camera, nullptr) != ARV_AUTO_OFF});
  }
  return settings;
}

std::vector<std::string> describe(ArvCamera* camera) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{} {}, serial number {}", text(arv_camera_get_vendor_name(camera, nullptr)),
                              text(arv_camera_get_model_name(camera, nullptr)),
                              text(arv_camera_get_device_serial_number(camera, nullptr))));
  gint x = 0;
  gint y = 0;
  gint width = 0;
  gint height = 0;
  arv_camera_get_sensor_size(camera, &width, &height, nullptr);
  lines.push_back(fmt::format("sensor: {}x{}", width, height));
  arv_camera_get_region(camera, &x, &y, &width, &height, nullptr);
  lines.push_back(fmt::format("frames: {}x{} at ({}, {}), {}", width, height, x, y,
                              text(arv_camera_get_pixel_format_as_string(camera, nullptr))));
  lines.push_back(fmt::format("formats: {}", fmt::join(words_of(camera, "PixelFormat"), " ")));
  if (arv_camera_is_frame_rate_available(camera, nullptr)) {
    Range range;
    arv_camera_get_frame_rate_bounds(camera, &range.least, &range.most, nullptr);
    lines.push_back(fmt::format("frames/s: {:.4g} ({:.4g} to {:.4g})", arv_camera_get_frame_rate(camera, nullptr),
                                range.least, range.most));
  }
  for (const CameraSetting& setting : settings_of(camera))
    lines.push_back(fmt::format("{}: {:.4g}{} ({:.4g} to {:.4g})", setting.name, setting.value,
                                setting.name == "exposure" ? " s" : "", setting.least, setting.most));
  std::string triggers = fmt::format("{}", fmt::join(words_of(camera, "TriggerSource"), " "));
  lines.push_back(fmt::format("triggers: {}", triggers.empty() ? "none" : triggers));
  const ClockFeatures clock = clock_features(camera);
  lines.push_back(fmt::format("clock: {}", clock.latch != nullptr ? clock.latch : "cannot be read"));
  return lines;
}

}  // namespace skein::vision::detail
