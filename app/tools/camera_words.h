#pragma once

#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "vision/frames/frame_source.h"

namespace CLI {
class App;
}

namespace skein::app {

/// How a camera is asked to be, in the words of `skein track` and `skein calibrate`.
struct CameraWords {
  std::string size{};    ///< "1280x960"; empty: the calibration's, or as it is set
  std::string format{};  ///< "MJPG"; empty: any
  double rate = 0.0;
  std::string trigger{};                ///< "software", "Line1"; empty: the camera's own clock
  std::vector<std::string> settings{};  ///< "exposure=0.005"

  /// `calibrated`: the frames' size is the calibration's, and not asked for.
  void add_to(CLI::App& command, bool calibrated);
  /// The same for vision::open_source. Waiting for a camera that does not deliver ends with the program. The error says
  /// which word is wrong, or that `source` is no camera.
  tl::expected<vision::SourceOptions, std::string> read(const std::string& source) const;
};

/// None, or why `source` cannot be opened whatever there is on this machine.
std::string wrong_source(const std::string& source);

}  // namespace skein::app
