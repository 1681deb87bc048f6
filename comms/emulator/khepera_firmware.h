#pragma once

#include "comms/emulator/robot_firmware.h"
#include "core/kinematics/robot_type.h"
#include "core/kinematics/step_motor.h"

namespace skein::comms {

/// The server that a Khepera IV runs on its serial line or Bluetooth channel (K-Team's kh4server): a line in, a line
/// out. Its bugs are emulated, too: it discards input that arrives while it answers, and arguments missing from a line
/// keep their values from an earlier line. It has no watchdog. It knows the commands B, D, E, I, R, V and M; those for
/// sensors and lights, which need no wheels, get the answer to an unknown command, "$".
class KheperaFirmware final : public RobotFirmware {
 public:
  explicit KheperaFirmware(const core::RobotType& type) : fastest_(type.wheels.max_step_rate) {}

  void receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) override;
  void advance(double dt) noexcept override {
    left_.advance(dt);
    right_.advance(dt);
  }
  core::WheelSpeeds wheels() const noexcept override { return {left_.settled_rate(), right_.settled_rate()}; }
  core::WheelSpeeds told() const noexcept override { return told_; }
  std::uint64_t times_told() const noexcept override { return times_told_; }
  void boot() noexcept override;
  void set_battery(double volts) noexcept override { volts_ = volts; }
  void swap_wheels(bool swapped) noexcept override { swapped_ = swapped; }
  void silence_encoders(bool silent) noexcept override { silent_ = silent; }

 private:
  std::string answer(const std::string& line);
  void tell(long left, long right) noexcept;
  long pulses(const core::StepMotor& motor) const noexcept;

  double fastest_;
  std::string line_;
  long arguments_[2] = {0, 0};  // from the newest line that had them
  core::StepMotor left_{core::MotorModel::servo}, right_{core::MotorModel::servo};
  core::WheelSpeeds told_;
  std::uint64_t times_told_ = 0;
  double volts_ = 8.0;
  bool swapped_ = false, silent_ = false;
};

}  // namespace skein::comms
