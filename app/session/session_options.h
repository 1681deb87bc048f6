#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/run/tick_record.h"
#include "comms/emulator/radio_faults.h"

namespace skein::app {

class TagCrops;

struct SessionOptions {
  /// The clock that a session runs on.
  enum class Clock {
    wall,     ///< real time: absolute deadlines, camera and links on threads of their own
    virtual_  ///< as fast as possible, everything in step; then use Session::run
  };

  bool pictures = false;             ///< keep the newest camera image
  std::vector<RecordSink*> sinks{};  ///< get every row of the run, on a separate thread in a real-time session
  std::string video{};               ///< record the camera's frames to this film (Matroska); empty: none
  TagCrops* crops = nullptr;         ///< get a picture of each tag that is not seen; null: none are wanted
  /// Real robots get a guard, a separate process that stops them if this one is killed (safety_net.h).
  bool guard = false;
  std::vector<comms::Fault> faults{};  ///< for practice; they count only the robots with link "loopback"
  /// A camera that cannot be opened does not fail the session: it is retried every second until it opens. No robot is
  /// seen meanwhile, so that no run can start.
  bool await_camera = false;
  std::string program{};   ///< that hosts libraries of controllers, a `skein`; empty: this program
  bool every_tag = false;  ///< look for all tags of the family, see CameraRig::newest
  /// Wall clock: a simulation without a controller of its own runs every tick at exactly its time at speed 1 as well,
  /// so that a busy machine makes it slower but does not change it.
  bool paced = false;
  /// Called several times per second while robots are being reached; false ends the opening.
  std::function<bool()> keep_on{};
};

}  // namespace skein::app
