#pragma once

#include <arv.h>

#include <string>
#include <vector>

#include "vision/aravis/genicam.h"
#include "vision/frames/camera_setting.h"
#include "vision/frames/frame_source.h"

namespace skein::vision::detail {

/// A camera by its name or its network address, or none and why in `failed`.
Object<ArvCamera> open_named(const std::string& name, Failure& failed);

/// Sets controls, in order, and reads them back. Names: GenICam features that are numbers, switches or menus (by their
/// number), in their own units ("BinningHorizontal"), or
///   exposure   [s]  turns the automatic off (0: on)
///   gain            camera's units, as a rule dB; turns its automatic off
/// Empty, or the first that is not there or out of range, with what is allowed. `notices` gets a line for each that
/// took another value, and for an automatic that is on and was not asked for.
std::string set_controls(ArvCamera* camera, const std::string& name, const ControlSettings& settings,
                         std::vector<std::string>& notices);

/// Exposure and gain, as far as the camera has them.
std::vector<CameraSetting> settings_of(ArvCamera* camera, Silence& silence);

/// Lines for people: formats, size, rate, exposure, gain, triggers, and whether its clock can be read.
std::vector<std::string> describe(ArvCamera* camera, Silence& silence);

/// What of an enumeration is there now.
std::vector<std::string> words_of(ArvCamera* camera, const char* feature, Silence& silence);

/// How a camera's clock is read: by a command, then from a value in units of 1 s / frequency.
struct ClockFeatures {
  const char* latch = nullptr;
  const char* value = nullptr;
  double frequency = 1e9;  // [1/s]
};
/// GigE Vision's first names or those of SFNC 2; `latch` null: it cannot be read.
ClockFeatures clock_features(ArvCamera* camera, Silence& silence);

}  // namespace skein::vision::detail
