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
  std::vector<FoundCamera> cameras;  ///< in the order of vision::source_kinds()
  std::string problem{};             ///< why some could not be searched; empty: none
};

/// Takes about a second.
FoundCameras find_cameras();
/// The same on a thread of its own, without waiting: the future may be dropped.
std::future<FoundCameras> find_cameras_aside();

}  // namespace skein::app
