#pragma once

#include "vision/calibration/calibration.h"

namespace skein::test {

/// Of a camera with half as many pixels a side: what a film costs is the coding of its pixels' noise.
inline vision::Calibration half_as_fine(vision::Calibration camera) {
  camera.width /= 2, camera.height /= 2;
  camera.fx *= 0.5, camera.fy *= 0.5;
  camera.cx = 0.5 * camera.cx - 0.25, camera.cy = 0.5 * camera.cy - 0.25;  // pixels' centres are whole numbers
  return camera;
}

}  // namespace skein::test
