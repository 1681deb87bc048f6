#pragma once

#include <memory>

#include "comms/emulator/robot_firmware.h"
#include "core/kinematics/robot_type.h"

namespace skein::comms {

/// The program of a robot of this type, for types with a protocol of their own; null: an e-puck's (EpuckFirmware).
std::unique_ptr<RobotFirmware> make_firmware(const core::RobotType& type);

}  // namespace skein::comms
