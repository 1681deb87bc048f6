#pragma once

#include <future>
#include <string>
#include <vector>

namespace skein::app {

/// A camera that is connected.
struct FoundCamera {
  std::string address;  ///< "v4l2:/dev/video0", "aravis:Basler-12345678"
  std::string what;     ///< "HD Webcam (uvcvideo)"
};

struct FoundCameras {
  std::vector<FoundCamera> cameras;  ///< those of the kernel, then those that answer in the network and on USB3 Vision
  std::string problem{};             ///< why nobody could be asked there; empty: none
};

/// Takes about a second.
FoundCameras find_cameras();
/// The same on a thread of its own, for which nobody waits: the future may be dropped.
std::future<FoundCameras> find_cameras_aside();

}  // namespace skein::app
