#pragma once

#include <string>
#include <vector>

namespace skein::vision {

/// One of "exposure", "gain" and "focus" as a camera has it: exposure in seconds, the others in its driver's units.
struct CameraSetting {
  std::string name{};
  double value = 0.0, least = 0.0, most = 0.0;
  double step = 0.0;       // 0: any value between the two
  bool automatic = false;  // the camera changes it by itself
  bool counted = false;    // an exposure in whole numbers of a unit that the driver does not state
};

struct CameraSettings {
  std::vector<CameraSetting> all{};    // that the camera has
  std::vector<std::string> notices{};  // a line for each that took another value than requested
};

}  // namespace skein::vision
