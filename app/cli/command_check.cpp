#include <fmt/format.h>

#include "app/cli/commands.h"
#include "app/experiment/certificate.h"
#include "app/run/exit_status.h"
#include "app/session/camera_rig.h"

namespace skein::app {

int check(const ExperimentRequest& request) {
  const auto experiment = load(request);
  if (!experiment) return wrong_input;
  if (experiment->camera.kind() != CameraKind::absent)
    if (const auto calibration = camera_calibration(*experiment); !calibration) {
      fmt::print(stderr, "skein: {}\n", calibration.error());
      return wrong_input;
    }
  const Certificate certificate = certify(*experiment);
  fmt::print("experiment: {}\n{}", experiment->name, as_lines(certificate));
  return certificate.sound() ? done : wrong_input;
}

}  // namespace skein::app
