#include "comms/emulator/make_firmware.h"
#include "comms/emulator/khepera_firmware.h"
#include "comms/emulator/open_firmware.h"

namespace skein::comms {

std::unique_ptr<RobotFirmware> make_firmware(const core::RobotType& type) {
  if (type.protocol == "khepera4") return std::make_unique<KheperaFirmware>(type);
  if (type.protocol == "open") return std::make_unique<OpenFirmware>(type);
  return nullptr;
}

}  // namespace skein::comms
