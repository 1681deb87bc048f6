#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "vision/frames/frame_source.h"

namespace skein::app {

/// A camera's requested settings, as in the options of `skein track` and `skein calibrate`.
struct CameraWords {
  std::string size{};    ///< "1280x960"; empty: the calibration's, or as it is set
  std::string format{};  ///< "MJPG"; empty: any
  double rate = 0.0;
  std::string trigger{};                ///< "software", "Line1"; empty: the camera's own clock
  std::vector<std::string> settings{};  ///< "exposure=0.005"

  /// As options of vision::open_source. Waiting for a camera that delivers no frames ends with the program. The error
  /// names the wrong option, or says that `source` is not a camera.
  tl::expected<vision::SourceOptions, std::string> read(const std::string& source) const;
};

/// What a source may look like, for help: "images:DIR, video:FILE, ...".
std::string source_forms();

/// None, or why `source` can never be opened.
std::string wrong_source(const std::string& source);

}  // namespace skein::app
