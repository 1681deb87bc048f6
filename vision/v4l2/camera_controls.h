#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "vision/frames/camera_setting.h"
#include "vision/frames/frame_source.h"
#include "vision/v4l2/v4l2_kernel.h"

namespace skein::vision {

namespace detail {
class V4l2Device;
}

/// Something about a camera that can be set, in the driver's own units.
struct CameraControl {
  std::string name{};  // as v4l2-ctl writes it: lower case, "_" for every other character than a letter or digit
  std::uint32_t id = 0;
  std::int64_t least = 0, most = 0, step = 1, standard = 0, value = 0;
  std::vector<std::pair<std::int64_t, std::string>> choices{};  // of a menu
  bool settable = true;                                         // false: read only, or another control is in the way
};

/// A kind of frame that a camera gives.
struct CameraFormat {
  std::string format{};  // "YUYV"
  int width = 0;
  int height = 0;
  std::vector<double> rates{};  // [frames/s]; empty: the driver does not say
};

struct CameraDescription {
  std::string card{};
  std::string driver{};
  std::vector<CameraFormat> formats{};
  std::vector<CameraControl> controls{};
};

/// A line for the operator: "YUYV 640x480, frames/s: 30 25".
std::string to_text(const CameraFormat& format);
/// The same of a control: "gain = 10  (0 to 255; default 32)".
std::string to_text(const CameraControl& control);

/// A camera's modes and settings. Does not disturb a reader of its frames.
tl::expected<CameraDescription, std::string> describe_camera(const std::string& device,
                                                             V4l2Kernel& kernel = system_kernel());

/// Sets controls, in order, and reads them back. Names: the driver's (see CameraControl), in its units, or
///   exposure   [s]  how long the shutter is open; turns automatic exposure off (0: on). Where the driver only has a
///                   control without a unit (V4L2_CID_EXPOSURE), a whole number of its units
///   gain            driver's units; turns automatic gain off
///   focus           driver's units; turns the autofocus off
/// An unknown name or a value out of range is an error, which states what is allowed. Returns a line for each control
/// that took another value than requested.
tl::expected<std::vector<std::string>, std::string> set_controls(const detail::V4l2Device& device,
                                                                 const ControlSettings& settings);

/// Sets controls of a camera and reads back its exposure, gain and focus. A reader may be using the camera meanwhile.
tl::expected<CameraSettings, std::string> v4l2_settings(const std::string& device, const ControlSettings& set = {},
                                                        V4l2Kernel& kernel = system_kernel());

/// Which of "exposure", "gain" and "focus" the camera sets by itself at present.
std::vector<std::string> automatics_on(const CameraDescription& camera);

/// The same of an open camera, except an exposure that `asked` wants automatic (0).
std::vector<std::string> automatics_on(const detail::V4l2Device& device, const ControlSettings& asked);

/// The present value of one of these three, in the units of set_controls; none: the camera has no such control.
std::optional<double> present_setting(const CameraDescription& camera, const std::string& name);

/// The exposure time that a camera keeps; none: it sets it by itself, or has no control with a unit. [s]
std::optional<double> fixed_exposure(const detail::V4l2Device& device);

/// "exposure=0.005" as a setting; none where it is something else.
tl::expected<std::pair<std::string, double>, std::string> parse_setting(std::string_view text);

}  // namespace skein::vision
