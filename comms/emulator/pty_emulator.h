#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "comms/emulator/radio_faults.h"
#include "core/kinematics/step_rate.h"

namespace skein::comms {

/// Emulated e-pucks behind pseudo-terminals: to a program they are serial lines with robots at the end. One thread for
/// all of them.
class PtyEmulator {
 public:
  /// Called on the emulator's thread when a robot's wheels change, BEFORE the reply to the command is written: whoever
  /// gets the reply knows that the callback is done. It must not throw, and may call wheels() and device() only.
  using WheelsChanged = std::function<void(std::size_t robot, const core::WheelSpeeds& actual)>;

  /// `clock`: seconds, never decreasing; drives the encoders; called on the emulator's thread (and once here).
  /// `directory`: where the robots' names robot1, robot2, ... are made, symbolic links that follow a robot whose
  /// pseudo-terminal changes (see hang_up); made if it does not exist; empty: a new directory for temporary files.
  /// `faults`: what goes wrong by itself, counted from now on, see EmulatedEpuck; a broken connection is a line that
  /// hangs up, and its successor a line that nobody answers while the fault lasts. `seed`: of what is random in them.
  /// Throws std::system_error when the system refuses a pseudo-terminal or a file.
  PtyEmulator(const std::vector<core::MotorModel>& robots, WheelsChanged on_wheels, std::function<double()> clock,
              std::string directory = {}, const std::vector<Fault>& faults = {}, std::uint64_t seed = 0);
  ~PtyEmulator();  ///< ends the thread, removes the names, hangs up
  PtyEmulator(const PtyEmulator&) = delete;
  PtyEmulator& operator=(const PtyEmulator&) = delete;

  std::size_t size() const noexcept;
  /// The path to open as a serial line; the same for the emulator's life. Any thread.
  std::string device(std::size_t robot) const;
  /// The step rates that a robot's motors run. Any thread. [steps/s]
  core::WheelSpeeds wheels(std::size_t robot) const;

  // Faults, for tests. They return when done. Any thread but the emulator's own.
  void hang_up(std::size_t robot);  ///< breaks the link; device() leads to a new line at once; wheels go on
  void reboot(std::size_t robot);   ///< off and on again: wheels stand, counters 0, greeting sent
  void silence(std::size_t robot,
               bool silent);  ///< while silent the robot hears nothing and says nothing; wheels go on
  void say(std::size_t robot, const std::string& bytes);  ///< sends bytes to the host as if the robot had (noise)

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace skein::comms
