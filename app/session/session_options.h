#pragma once

#include <string>
#include <vector>

#include "app/run/tick_record.h"
#include "comms/emulator/radio_faults.h"

namespace skein::app {

struct SessionOptions {
  /// The clock that a session runs on.
  enum class Clock {
    wall,     ///< real time: absolute deadlines, camera and links on threads of their own
    virtual_  ///< as fast as the machine goes, everything in step; Session::run is then the way to run it
  };

  bool pictures = false;           ///< keep the newest camera picture at hand
  std::vector<RecordSink*> sinks;  ///< told every row of the run, on a thread of their own in a real-time session
  std::string video{};             ///< keep the camera's frames in this film (Matroska); empty: none
  /// Real robots get a guard, a process of its own that stops them should this one be killed (safety_net.h).
  bool guard = false;
  std::vector<comms::Fault> faults{};  ///< of the robots with link "loopback", counted among themselves, for practice
  /// A camera that cannot be opened does not fail the session: it is tried again every second until it opens. No robot
  /// is seen meanwhile, so that nothing can be started.
  bool await_camera = false;
  std::string program{};   ///< that hosts libraries of controllers, a `skein`; empty: this program
  bool every_tag = false;  ///< look for all tags that there are, see CameraRig::newest
};

}  // namespace skein::app
