#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "core/kinematics/differential_drive.h"

namespace skein::comms {

/// The program inside an emulated robot as a state machine: bytes and seconds in, bytes and wheel speeds out. No I/O,
/// no clock. Not thread-safe.
class RobotFirmware {
 public:
  virtual ~RobotFirmware() = default;

  /// Feeds the bytes of one write of the host, and appends the robot's answer to `reply`.
  virtual void receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) = 0;
  virtual void advance(double dt) noexcept = 0;  ///< lets `dt` seconds pass

  virtual core::WheelSpeeds wheels() const noexcept = 0;  ///< that the motors run [steps/s]
  virtual core::WheelSpeeds told() const noexcept = 0;    ///< last sent to the motors [steps/s]
  virtual std::uint64_t times_told() const noexcept = 0;  ///< how often speeds were sent to them
  /// Seconds until it next acts without input from the host; infinity: never.
  virtual double acts_in() const noexcept { return std::numeric_limits<double>::infinity(); }

  virtual void boot() noexcept = 0;                    ///< switches it off and on
  virtual std::string greeting() const { return {}; }  ///< what it says when it boots
  virtual void new_host() noexcept {}                  ///< another host has connected, where it can tell

  // Defects: a reboot does not clear them.
  virtual void set_battery(double volts) noexcept = 0;
  virtual void swap_wheels(bool swapped) noexcept = 0;      ///< left commands drive and count right
  virtual void silence_encoders(bool silent) noexcept = 0;  ///< counters read 0

 protected:
  RobotFirmware() = default;
  RobotFirmware(const RobotFirmware&) = default;
  RobotFirmware& operator=(const RobotFirmware&) = default;
};

}  // namespace skein::comms
