#pragma once

#include <memory>
#include <string>
#include <vector>

#include "vision/frames/camera_setting.h"
#include "vision/frames/frame_source.h"

// GigE Vision and USB3 Vision through Aravis, a module of its own: GLib, GIO, libusb and libxml2 come with it.

namespace skein::vision {

/// A GigE Vision or USB3 Vision camera that has answered.
struct NetworkCamera {
  std::string name{};      ///< what follows "aravis:": vendor, model and serial number
  std::string model{};     ///< vendor and model
  std::string address{};   ///< in the network, or on the USB
  std::string protocol{};  ///< "GigEVision", "USB3Vision"
};

struct Aravis {
  /// Opens a camera by its name or its network address; null on failure, with the reason in `error`.
  std::unique_ptr<FrameSource> (*open)(const std::string& camera, const SourceOptions& options, std::string& error);

  /// Those that answer within a second.
  std::vector<NetworkCamera> (*discover)();

  /// A description for the operator, line by line: what a camera can do and how it is set; empty on failure, with the
  /// reason in `error`. Does not change the camera, but no other reader may be using it.
  std::vector<std::string> (*describe)(const std::string& camera, std::string& error);

  /// Sets controls and reads back exposure and gain; empty on failure, with the reason in `error`. No other reader may
  /// be using it.
  CameraSettings (*settings)(const std::string& camera, const ControlSettings& set, std::string& error);
};

/// Carries a number for the same reason as media_symbol; SourceOptions counts too.
inline constexpr const char* aravis_symbol = "skein_aravis_4";

}  // namespace skein::vision
