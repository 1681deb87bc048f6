#pragma once

#include <arv.h>

#include <string>
#include <vector>

#include "vision/aravis/genicam.h"
#include "vision/frames/camera_setting.h"
#include "vision/frames/frame_source.h"
#include "vision/modules/aravis.h"

namespace skein::vision::detail {

/// The GigE and USB3 cameras that answer within a second. Thread-safe: searches run one after the other.
std::vector<NetworkCamera> discover();

/// Opens a camera by its name or its network address; null on failure, with the reason in `failed`.
Object<ArvCamera> open_named(const std::string& name, Failure& failed);

/// Sets controls, in order, and reads them back. Names: GenICam features that are numbers, switches or menus (by their
/// number), in their own units ("BinningHorizontal"), or
///   exposure   [s]  turns automatic exposure off (0: on)
///   gain            camera's units, usually dB; turns automatic gain off
/// Returns empty, or an error: the first control that is missing or out of range, and what is allowed. `notices` gets a
/// line for each control that took another value, and for each automatic control that is on without being asked for.
std::string set_controls(ArvCamera* camera, const std::string& name, const ControlSettings& settings,
                         std::vector<std::string>& notices);

/// Which of "exposure" and "gain" the camera sets by itself and was not asked to.
std::vector<std::string> automatics_on(ArvCamera* camera, const ControlSettings& asked);

/// Exposure and gain, as far as the camera has them.
std::vector<CameraSetting> settings_of(ArvCamera* camera, Silence& silence);

/// A description for the operator, line by line: formats, size, rate, exposure, gain, triggers, and whether the
/// camera's clock can be read.
std::vector<std::string> describe(ArvCamera* camera, Silence& silence);

/// The entries of an enumeration that are available now.
std::vector<std::string> words_of(ArvCamera* camera, const char* feature, Silence& silence);

/// The features that read a camera's clock: a latch command, then a value in units of 1 s / frequency.
struct ClockFeatures {
  const char* latch = nullptr;
  const char* value = nullptr;
  double frequency = 1e9;  // [1/s]
};
/// The original names of GigE Vision or those of SFNC 2; `latch` null: the clock cannot be read.
ClockFeatures clock_features(ArvCamera* camera, Silence& silence);

}  // namespace skein::vision::detail
