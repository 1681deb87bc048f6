#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "comms/battery.h"
#include "comms/link_address.h"

namespace skein::comms {

/// What a robot says about itself, and whether its wheels do what they are told.
struct RobotCheck {
  std::string version;  ///< "Version 2.0 January 2018 GCtronic"; empty: it did not say
  Battery battery;
  int left_steps = 0;               ///< counted while only the left wheel was told to turn forward, left wheel [steps]
  int right_steps = 0;              ///< the same for the right wheel [steps]
  std::vector<std::string> faults;  ///< a sentence each; empty: none found
};

/// Connects to a robot, asks for version and battery, turns each wheel about 10 mm forward and compares the counters
/// with the command: wheels that are swapped or turn backwards, counters that are silent. The counters count steps of
/// the motors, so a wheel that slips or a cable behind the counters goes unseen; that takes a camera. The robot is
/// stopped before and after. Blocks for some seconds. The error: it cannot be reached, or was lost meanwhile.
tl::expected<RobotCheck, std::string> check_robot(const LinkAddress& address, double timeout_s);

}  // namespace skein::comms
