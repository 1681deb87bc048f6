#pragma once

#include <cmath>
#include <utility>

#include "app/experiment/experiment.h"
#include "vision/frames/frame_source.h"

namespace skein::app {

/// The controls that an experiment sets of a camera; those that it leaves unchanged are not among them.
inline vision::ControlSettings control_settings(const CameraSpec& camera) {
  vision::ControlSettings set;
  for (const auto& [name, value] :
       {std::pair("exposure", camera.exposure), {"gain", camera.gain}, {"focus", camera.focus}})
    if (!std::isnan(value)) set.emplace_back(name, value);
  return set;
}

}  // namespace skein::app
