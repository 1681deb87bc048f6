#include "vision/v4l2/camera_controls.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>

#include "vision/v4l2/v4l2_device.h"

namespace skein::vision {
namespace {

using detail::V4l2Device;

constexpr double exposure_unit = 1e-4;  // of V4L2_CID_EXPOSURE_ABSOLUTE [s]

std::string plain(const std::uint8_t* letters, std::size_t size) {
  const char* begin = reinterpret_cast<const char*>(letters);
  std::string name;
  for (const char c : std::string_view(begin, strnlen(begin, size))) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name;
}

std::optional<std::int64_t> value_of(const V4l2Device& device, std::uint32_t id) {
  v4l2_control control{};
  control.id = id;
  if (device.control(VIDIOC_G_CTRL, &control) == -1) return {};
  return control.value;
}

/// Those with a number for a value; a driver's tables and texts are none of ours.
std::vector<CameraControl> controls_of(const V4l2Device& device) {
  std::vector<CameraControl> controls;
  v4l2_queryctrl query{};
  for (query.id = V4L2_CTRL_FLAG_NEXT_CTRL; device.control(VIDIOC_QUERYCTRL, &query) == 0;
       query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
    const bool number = query.type == V4L2_CTRL_TYPE_INTEGER || query.type == V4L2_CTRL_TYPE_BOOLEAN ||
                        query.type == V4L2_CTRL_TYPE_MENU || query.type == V4L2_CTRL_TYPE_INTEGER_MENU;
    if (!number || (query.flags & V4L2_CTRL_FLAG_DISABLED) != 0) continue;
    CameraControl control;
    control.name = plain(query.name, sizeof query.name);
    control.id = query.id;
    control.least = query.minimum;
    control.most = query.maximum;
    control.step = std::max(1, query.step);
    control.standard = query.default_value;
    control.value = value_of(device, query.id).value_or(query.default_value);
    constexpr std::uint32_t in_the_way = V4L2_CTRL_FLAG_READ_ONLY | V4L2_CTRL_FLAG_INACTIVE | V4L2_CTRL_FLAG_GRABBED;
    control.settable = (query.flags & in_the_way) == 0;
    if (query.type == V4L2_CTRL_TYPE_MENU || query.type == V4L2_CTRL_TYPE_INTEGER_MENU)
      for (std::int64_t i = query.minimum; i <= query.maximum; ++i) {
        v4l2_querymenu item{};
        item.id = query.id;
        item.index = static_cast<std::uint32_t>(i);
        if (device.control(VIDIOC_QUERYMENU, &item) == -1) continue;  // menus have gaps
        const bool named = query.type == V4L2_CTRL_TYPE_MENU;
        control.choices.emplace_back(i, named ? plain(item.name, sizeof item.name) : std::to_string(item.value));
      }
    controls.push_back(std::move(control));
  }
  return controls;
}

std::vector<double> rates_of(const V4l2Device& device, std::uint32_t format, std::uint32_t width,
                             std::uint32_t height) {
  std::vector<double> rates;
  v4l2_frmivalenum interval{};
  interval.pixel_format = format;
  interval.width = width;
  interval.height = height;
  for (; device.control(VIDIOC_ENUM_FRAMEINTERVALS, &interval) == 0; ++interval.index) {
    const auto add = [&](const v4l2_fract& period) {
      if (period.numerator > 0) rates.push_back(static_cast<double>(period.denominator) / period.numerator);
    };
    if (interval.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      add(interval.discrete);
      continue;
    }
    add(interval.stepwise.min);
    add(interval.stepwise.max);
    break;
  }
  return rates;
}

std::vector<CameraFormat> formats_of(const V4l2Device& device) {
  std::vector<CameraFormat> formats;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  for (; device.control(VIDIOC_ENUM_FMT, &description) == 0; ++description.index) {
    v4l2_frmsizeenum size{};
    size.pixel_format = description.pixelformat;
    const auto add = [&](std::uint32_t width, std::uint32_t height) {
      formats.push_back({detail::four_letters(description.pixelformat), static_cast<int>(width),
                         static_cast<int>(height), rates_of(device, description.pixelformat, width, height)});
    };
    for (; device.control(VIDIOC_ENUM_FRAMESIZES, &size) == 0; ++size.index) {
      if (size.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
        add(size.discrete.width, size.discrete.height);
        continue;
      }
      add(size.stepwise.min_width, size.stepwise.min_height);
      add(size.stepwise.max_width, size.stepwise.max_height);
      break;
    }
  }
  return formats;
}

bool write(const V4l2Device& device, std::uint32_t id, std::int64_t value) {
  v4l2_control control{};
  control.id = id;
  control.value = static_cast<std::int32_t>(value);
  return device.control(VIDIOC_S_CTRL, &control) == 0;
}

/// The control behind a name of ours; what it is called by the driver where it is one of the driver's.
std::uint32_t id_of(const std::vector<CameraControl>& controls, const std::string& name) {
  if (name == "exposure") {
    const bool has_unit =
        std::any_of(controls.begin(), controls.end(), [](const auto& c) { return c.id == V4L2_CID_EXPOSURE_ABSOLUTE; });
    const bool has_other =
        std::any_of(controls.begin(), controls.end(), [](const auto& c) { return c.id == V4L2_CID_EXPOSURE; });
    return has_other && !has_unit ? V4L2_CID_EXPOSURE : V4L2_CID_EXPOSURE_ABSOLUTE;
  }
  if (name == "gain") return V4L2_CID_GAIN;
  if (name == "focus") return V4L2_CID_FOCUS_ABSOLUTE;
  const auto found = std::find_if(controls.begin(), controls.end(), [&](const auto& c) { return c.name == name; });
  return found == controls.end() ? 0 : found->id;
}

/// Turns off what would set it by itself. A camera without such an automatic does not mind.
void take_over(const V4l2Device& device, std::uint32_t id, bool automatic) {
  if (id == V4L2_CID_EXPOSURE_ABSOLUTE || id == V4L2_CID_EXPOSURE) {
    if (!automatic) {
      write(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL);
      write(device, V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0);  // which would lower the frame rate in the dark
    } else if (!write(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY)) {
      write(device, V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_AUTO);
    }
  }
  if (id == V4L2_CID_GAIN) write(device, V4L2_CID_AUTOGAIN, 0);
  if (id == V4L2_CID_FOCUS_ABSOLUTE) write(device, V4L2_CID_FOCUS_AUTO, 0);
}

/// Whether this value of V4L2_CID_EXPOSURE_AUTO leaves the exposure time to the camera.
bool sets_exposure(std::int64_t automatic) {
  return automatic != V4L2_EXPOSURE_MANUAL && automatic != V4L2_EXPOSURE_SHUTTER_PRIORITY;
}

/// What the camera sets by itself where this control has this value; null: nothing.
const char* automatic_of(std::uint32_t id, std::int64_t value) {
  if (id == V4L2_CID_EXPOSURE_AUTO) return sets_exposure(value) ? "exposure" : nullptr;
  if (id == V4L2_CID_AUTOGAIN) return value != 0 ? "gain" : nullptr;
  if (id == V4L2_CID_FOCUS_AUTO) return value != 0 ? "focus" : nullptr;
  return nullptr;
}

const CameraControl* find(const std::vector<CameraControl>& controls, std::uint32_t id) {
  const auto found = std::find_if(controls.begin(), controls.end(), [&](const auto& c) { return c.id == id; });
  return found == controls.end() ? nullptr : &*found;
}

double unit_of(std::uint32_t id) {
  return id == V4L2_CID_EXPOSURE_ABSOLUTE ? exposure_unit : 1.0;
}

std::string names_of(const std::vector<CameraControl>& controls) {
  std::string names;
  for (const CameraControl& control : controls) names += (names.empty() ? "" : ", ") + control.name;
  return names.empty() ? "none" : names;
}

}  // namespace

std::string to_text(const CameraFormat& format) {
  std::vector<std::string> rates;
  rates.reserve(format.rates.size());
  for (const double rate : format.rates) rates.push_back(fmt::format("{:.4g}", rate));
  return fmt::format("{} {}x{}{}{}", format.format, format.width, format.height,
                     rates.empty() ? "" : ", frames/s: ", fmt::join(rates, " "));
}

std::string to_text(const CameraControl& control) {
  std::string text = fmt::format("{} = {}", control.name, control.value);
  if (control.choices.empty()) {
    text += fmt::format("  ({} to {}", control.least, control.most);
    if (control.step != 1) text += fmt::format(" in steps of {}", control.step);
  } else {
    std::vector<std::string> choices;
    choices.reserve(control.choices.size());
    for (const auto& [value, name] : control.choices) choices.push_back(fmt::format("{}: {}", value, name));
    text += fmt::format("  ({}", fmt::join(choices, ", "));
  }
  return text + fmt::format("; default {}{})", control.standard, control.settable ? "" : "; cannot be set now");
}

tl::expected<CameraDescription, std::string> describe_camera(const std::string& path, V4l2Kernel& kernel) {
  V4l2Device device(path, kernel);
  if (std::string problem = device.open(); !problem.empty()) return tl::unexpected(problem);
  return CameraDescription{device.card(), device.driver(), formats_of(device), controls_of(device)};
}

std::vector<std::string> automatics_on(const CameraDescription& camera) {
  std::vector<std::string> names;
  for (const CameraControl& control : camera.controls)
    if (const char* name = automatic_of(control.id, control.value)) names.emplace_back(name);
  return names;
}

std::vector<std::string> automatics_on(const V4l2Device& device, const ControlSettings& asked) {
  std::vector<std::string> names;
  for (const std::uint32_t id : {V4L2_CID_EXPOSURE_AUTO, V4L2_CID_AUTOGAIN, V4L2_CID_FOCUS_AUTO}) {
    const auto value = value_of(device, id);
    if (const char* name = value ? automatic_of(id, *value) : nullptr) names.emplace_back(name);
  }
  const bool wanted = std::any_of(asked.begin(), asked.end(),
                                  [](const auto& one) { return one.first == "exposure" && one.second == 0.0; });
  if (wanted) std::erase(names, "exposure");
  return names;
}

std::optional<double> present_setting(const CameraDescription& camera, const std::string& name) {
  const CameraControl* control = find(camera.controls, id_of(camera.controls, name));
  if (control == nullptr) return {};
  return unit_of(control->id) * static_cast<double>(control->value);
}

tl::expected<CameraSettings, std::string> v4l2_settings(const std::string& path, const ControlSettings& set,
                                                        V4l2Kernel& kernel) {
  V4l2Device device(path, kernel);
  if (std::string problem = device.open(); !problem.empty()) return tl::unexpected(problem);
  auto notices = set_controls(device, set);
  if (!notices) return tl::unexpected(notices.error());
  CameraSettings settings{.notices = std::move(*notices)};
  const CameraDescription now{.controls = controls_of(device)};
  const std::vector<std::string> automatics = automatics_on(now);
  for (const char* name : {"exposure", "gain", "focus"}) {
    const CameraControl* control = find(now.controls, id_of(now.controls, name));
    if (control == nullptr) continue;
    const double unit = unit_of(control->id);
    settings.all.push_back({.name = name,
                            .value = unit * static_cast<double>(control->value),
                            .least = unit * static_cast<double>(control->least),
                            .most = unit * static_cast<double>(control->most),
                            .step = unit * static_cast<double>(control->step),
                            .automatic = std::find(automatics.begin(), automatics.end(), name) != automatics.end(),
                            .counted = control->id == V4L2_CID_EXPOSURE});
  }
  return settings;
}

std::optional<double> fixed_exposure(const V4l2Device& device) {
  const auto automatic = value_of(device, V4L2_CID_EXPOSURE_AUTO);
  const auto value = value_of(device, V4L2_CID_EXPOSURE_ABSOLUTE);
  if (!value || (automatic && sets_exposure(*automatic))) return {};
  return exposure_unit * static_cast<double>(*value);
}

tl::expected<std::vector<std::string>, std::string> set_controls(const V4l2Device& device,
                                                                 const ControlSettings& settings) {
  std::vector<std::string> differing;
  if (settings.empty()) return differing;
  for (const auto& [name, wanted] : settings) {
    // Asked again for each: one control opens and closes the way for others.
    const std::vector<CameraControl> before = controls_of(device);
    const std::uint32_t id = id_of(before, name);
    const bool automatic = name == "exposure" && wanted == 0.0;
    take_over(device, id, automatic);
    if (automatic) continue;
    const std::vector<CameraControl> controls = controls_of(device);
    const CameraControl* control = find(controls, id);
    if (id == 0 || control == nullptr)
      return tl::unexpected(fmt::format("{}: has no control {}; it has: {}", device.path(), name, names_of(controls)));
    const double unit = unit_of(id);
    if (id == V4L2_CID_EXPOSURE && wanted != std::round(wanted))
      return tl::unexpected(
          fmt::format("{}: exposure = {}; allowed: a whole number from {} to {}, since the driver does not say how "
                      "many seconds one is",
                      device.path(), wanted, control->least, control->most));
    const double value = std::round(wanted / unit);
    if (!(value >= static_cast<double>(control->least) && value <= static_cast<double>(control->most)))
      return tl::unexpected(fmt::format("{}: {} = {}; allowed: {} to {}", device.path(), name, wanted,
                                        unit * static_cast<double>(control->least),
                                        unit * static_cast<double>(control->most)));
    if (!write(device, id, static_cast<std::int64_t>(value)))
      return tl::unexpected(device.failed(fmt::format("does not take {} = {}", name, wanted)));
    const auto now = value_of(device, id);
    if (now && static_cast<double>(*now) != value)
      differing.push_back(
          fmt::format("{}: {} is {}, not {}", device.path(), name, unit * static_cast<double>(*now), wanted));
  }
  return differing;
}

tl::expected<std::pair<std::string, double>, std::string> parse_setting(std::string_view text) {
  const std::size_t equals = text.find('=');
  double value = 0.0;
  if (equals != std::string_view::npos && equals > 0) {
    const std::string_view number = text.substr(equals + 1);
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    if (error == std::errc{} && end == number.data() + number.size() && std::isfinite(value))
      return std::pair(std::string(text.substr(0, equals)), value);
  }
  return tl::unexpected(fmt::format("\"{}\"; allowed: name=number, such as exposure=0.005", text));
}

}  // namespace skein::vision
