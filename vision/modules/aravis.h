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
  /// A camera by its name or its network address, or none and why in `error`.
  std::unique_ptr<FrameSource> (*open)(const std::string& camera, const SourceOptions& options, std::string& error);

  /// Those that answer within a second.
  std::vector<NetworkCamera> (*discover)();

  /// What a camera can do and how it is set, for people, line by line; none and why in `error`. Does not change it, but
  /// nobody else may be reading frames from it.
  std::vector<std::string> (*describe)(const std::string& camera, std::string& error);

  /// Sets controls and reads back what exposure and gain are then; nothing and why in `error`. Nobody else may be
  /// reading frames from it.
  CameraSettings (*settings)(const std::string& camera, const ControlSettings& set, std::string& error);
};

/// What the kernel holds at most for a program that receives, until the program reads it, and what is enough for
/// several frames of every camera. Debian's own limit is a sixth of a megapixel. [bytes]
inline constexpr const char* receive_buffer_setting = "/proc/sys/net/core/rmem_max";
inline constexpr long good_receive_buffer_limit = 32L << 20;

/// Carries a number for the same reason as media_symbol; SourceOptions counts too.
inline constexpr const char* aravis_symbol = "skein_aravis_3";

}  // namespace skein::vision
