#pragma once

#include "app/experiment/experiment.h"

namespace skein::app {

/// Whether it shows real robots: a device, or a film from one.
bool is_hardware(CameraKind camera) noexcept;

/// Whether an experiment has a real robot, or a camera that shows real ones.
bool has_hardware(const Experiment& experiment);

}  // namespace skein::app
