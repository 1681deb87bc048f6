#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "comms/emulator/emulated_epuck.h"

namespace skein::comms {

/// An emulated e-puck2 with the WiFi firmware: a TCP server for one client at a time, on a thread of its own.
class TcpEpuck {
 public:
  /// Called on the emulator's thread when the wheels change, before the answer is written. It must not throw.
  using WheelsChanged = std::function<void(const core::WheelSpeeds& actual)>;

  /// Listens on 127.0.0.1, or on every address of the machine. `port` 0: one that is free. `clock`, `faults` and `seed`
  /// as for EmulatedEpuck; `clock` is called on the emulator's thread, and once here. Throws std::system_error when
  /// the port cannot be had.
  explicit TcpEpuck(std::function<double()> clock, int port = 0, WheelsChanged on_wheels = {},
                    std::vector<Fault> faults = {}, std::uint64_t seed = 0, bool every_address = false);
  ~TcpEpuck();  ///< ends the thread, breaks the connection
  TcpEpuck(const TcpEpuck&) = delete;
  TcpEpuck& operator=(const TcpEpuck&) = delete;

  int port() const noexcept;
  core::WheelSpeeds wheels() const;  ///< that the motors run. Any thread. [steps/s]

  // Faults, for tests. Any thread but the emulator's own.
  void hang_up();             ///< breaks the connection; wheels go on
  void silence(bool silent);  ///< while silent the robot hears nothing and says nothing; wheels go on
  void say(const std::vector<std::uint8_t>& bytes);  ///< to the host, as if the robot had

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace skein::comms
