#include "app/experiment/hardware.h"

#include <algorithm>

namespace skein::app {

bool is_hardware(CameraKind camera) noexcept {
  switch (camera) {
    case CameraKind::recorded:
    case CameraKind::live:
      return true;
    case CameraKind::absent:
    case CameraKind::synthetic:
      break;
  }
  return false;
}

bool has_hardware(const Experiment& experiment) {
  return is_hardware(experiment.camera.kind()) || std::any_of(experiment.robots.begin(), experiment.robots.end(),
                                                              [](const RobotSpec& robot) { return robot.is_real(); });
}

}  // namespace skein::app
