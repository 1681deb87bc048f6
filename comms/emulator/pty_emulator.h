#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "comms/emulator/emulator_loop.h"
#include "core/kinematics/robot_type.h"

namespace skein::comms {

/// Emulated robots behind pseudo-terminals: to a program they are serial lines with robots at the end.
class PtyEmulator {
 public:
  using WheelsTold = comms::WheelsTold;

  /// As EmulatorLoop. `directory`: where the robots' names robot1, robot2, ... are made, symbolic links that follow a
  /// robot whose pseudo-terminal changes (see hang_up); made if it does not exist; empty: a new directory for temporary
  /// files. A broken connection is a line that hangs up; the new line does not answer while the fault lasts. Throws
  /// std::system_error when the system refuses a pseudo-terminal or a file.
  PtyEmulator(const std::vector<core::MotorModel>& robots, WheelsTold on_wheels, std::function<double()> clock,
              std::string directory = {}, const std::vector<Fault>& faults = {}, std::uint64_t seed = 0);

  /// Robots of these types; none is null.
  PtyEmulator(const std::vector<const core::RobotType*>& robots, WheelsTold on_wheels, std::function<double()> clock,
              std::string directory = {}, const std::vector<Fault>& faults = {}, std::uint64_t seed = 0);

  std::size_t size() const noexcept { return loop_.size(); }
  /// The path to open as a serial line; the same for the emulator's life. Any thread.
  std::string device(std::size_t robot) const;
  /// The step rates that a robot's motors run. Any thread. [steps/s]
  core::WheelSpeeds wheels(std::size_t robot) const { return loop_.wheels(robot); }

  // Faults, for tests. They return when done. Any thread but the emulator's own.
  /// Breaks the link; device() leads to a new line at once; the wheels keep turning.
  void hang_up(std::size_t robot) { loop_.hang_up(robot); }
  /// Off and on again: wheels stand, counters 0, greeting sent.
  void reboot(std::size_t robot) { loop_.reboot(robot); }
  /// While silent the robot receives and sends nothing; the wheels keep turning.
  void silence(std::size_t robot, bool silent) { loop_.silence(robot, silent); }
  /// Sends bytes to the host as if the robot had (noise).
  void say(std::size_t robot, const std::string& bytes) { loop_.say(robot, bytes); }

 private:
  DeviceNames names_;
  EmulatorLoop loop_;
};

}  // namespace skein::comms
