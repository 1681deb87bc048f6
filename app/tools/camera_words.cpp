#include "app/tools/camera_words.h"

#include <fmt/format.h>

#include <cstdio>

#include "app/run/interrupted.h"
#include "vision/sources/open_source.h"
#include "vision/v4l2/camera_controls.h"

namespace skein::app {

tl::expected<vision::SourceOptions, std::string> CameraWords::read(const std::string& source) const {
  vision::SourceOptions options;
  options.keep_waiting = [] { return !interrupted(); };
  for (const std::string& text : settings) {
    const auto setting = vision::parse_setting(text);
    if (!setting) return tl::unexpected("--set " + setting.error());
    options.controls.push_back(*setting);
  }
  int end = 0;
  const bool is_size = std::sscanf(size.c_str(), "%dx%d%n", &options.width, &options.height, &end) == 2 &&
                       end == static_cast<int>(size.size()) && options.width > 0 && options.height > 0;
  if (!size.empty() && !is_size)
    return tl::unexpected(fmt::format("--size {}; allowed: WIDTHxHEIGHT, such as 1280x960", size));
  options.rate = rate;
  options.format = format;
  options.trigger = trigger;
  const char* const word = !settings.empty()  ? "--set"
                           : !size.empty()    ? "--size"
                           : !format.empty()  ? "--format"
                           : rate > 0.0       ? "--rate"
                           : !trigger.empty() ? "--trigger"
                                              : nullptr;
  if (word != nullptr && !vision::is_camera(source))
    return tl::unexpected(
        fmt::format("{}: {} is not a camera; allowed with {}: {}", word, source, word, vision::camera_forms()));
  return options;
}

std::string source_forms() {
  return vision::source_forms();
}

std::string wrong_source(const std::string& source) {
  const auto address = vision::parse_source(source);
  return address ? std::string() : address.error();
}

}  // namespace skein::app
