#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "comms/emulator/emulator_loop.h"

namespace skein::comms {

/// An emulated e-puck2 with the WiFi firmware: a TCP server for one client at a time.
class TcpEpuck {
 public:
  /// Listens on 127.0.0.1. `port` 0: any free port. `clock` as for EmulatorLoop. Throws std::system_error when the port
  /// is not available.
  explicit TcpEpuck(std::function<double()> clock, int port = 0);

  int port() const;
  core::WheelSpeeds wheels() const { return loop_.wheels(0); }  ///< that the motors run. Any thread. [steps/s]

  // Faults, for tests. Any thread but the emulator's own.
  void hang_up() { loop_.hang_up(0); }  ///< breaks the connection; the wheels keep turning
  void reboot() { loop_.reboot(0); }    ///< off and on again: wheels stand, all sockets are free
  void silence(bool silent) {
    loop_.silence(0, silent);
  }  ///< while silent it receives and sends nothing; wheels keep turning
  void say(const std::vector<std::uint8_t>& bytes) {  ///< to the host, as if the robot had
    loop_.say(0, {bytes.begin(), bytes.end()});
  }

 private:
  EmulatorLoop loop_;
};

}  // namespace skein::comms
