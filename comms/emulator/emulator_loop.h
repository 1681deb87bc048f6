#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "comms/emulator/endpoint.h"
#include "comms/emulator/epuck_firmware.h"
#include "comms/emulator/radio_faults.h"
#include "core/kinematics/step_rate.h"

namespace skein::comms {

/// Called on the emulator's thread when a robot's firmware sends its motors a speed [steps/s], new or not. The reply to
/// the command is written only AFTER this callback has returned. It must not throw, and may call wheels() and address()
/// only.
using WheelsTold = std::function<void(std::size_t robot, const core::WheelSpeeds& commanded)>;

/// Emulated robots and where hosts reach them, one thread for all.
class EmulatorLoop {
 public:
  struct Robot {
    core::MotorModel model = core::MotorModel::epuck2;
    EpuckProgram protocol = EpuckProgram::asercom;
    std::unique_ptr<Endpoint> endpoint = {};
    /// A robot other than an e-puck, instead of model and protocol.
    std::unique_ptr<RobotFirmware> firmware = {};
  };

  /// `clock`: seconds, never decreasing; drives the encoders; called on the emulator's thread (and once here).
  /// `faults`: faults that happen by themselves, timed from now on, see EmulatedEpuck; a broken connection is hung up,
  /// and no other is accepted while the fault lasts. `seed`: of their random parts. Throws std::system_error.
  EmulatorLoop(std::vector<Robot> robots, WheelsTold on_wheels, std::function<double()> clock,
               const std::vector<Fault>& faults, std::uint64_t seed);
  ~EmulatorLoop();  ///< ends the thread, hangs up
  EmulatorLoop(const EmulatorLoop&) = delete;
  EmulatorLoop& operator=(const EmulatorLoop&) = delete;

  std::size_t size() const noexcept;
  std::string address(std::size_t robot) const;  ///< see Endpoint; any thread
  /// The step rates at the speeds last sent to the motors [steps/s]; any thread.
  core::WheelSpeeds wheels(std::size_t robot) const;

  // Faults, for tests. They return when done. Any thread but the emulator's own.
  void hang_up(std::size_t robot);
  void reboot(std::size_t robot);
  void silence(std::size_t robot, bool silent);
  void say(std::size_t robot, const std::string& bytes);

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace skein::comms
