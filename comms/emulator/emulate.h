#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "comms/emulator/radio_faults.h"
#include "core/kinematics/robot_type.h"

namespace skein::comms {

/// The options of `skein emulate`.
struct EmulateOptions {
  std::size_t robots = 1;  ///< how many on pseudo-terminals, 1 or more
  /// Where robots listen instead, one each, see parse_listen_address(); if there are any, none is on a pseudo-terminal.
  std::vector<std::string> listen{};
  /// The type of all robots, except that a robot on TCP is an e-puck2 and one on UDP speaks the open protocol.
  const core::RobotType* model = core::find_robot_type("epuck2");
  std::string directory{};      ///< where robot1, robot2, ... appear; empty: a new directory for temporary files
  bool verbose = false;         ///< print every change of a robot's wheels
  std::vector<Fault> faults{};  ///< faults that happen by themselves; times count from the start
  std::uint64_t seed = 0;       ///< of their random parts
  /// Prints a line, and what went wrong, both without a line end; empty: on stdout and stderr, as it is.
  std::function<void(const std::string&)> say{}, complain{};
};

/// Runs emulated robots until SIGINT or SIGTERM comes (to the process or to this thread). Prints one line
/// "robot N: ADDRESS" for each on stdout, as an experiment file names it. Returns the program's exit status: 0, 2
/// (options), 3 (the system refused). Blocks both signals in the calling thread meanwhile: call it before other threads
/// are started.
int emulate(const EmulateOptions& options);

}  // namespace skein::comms
