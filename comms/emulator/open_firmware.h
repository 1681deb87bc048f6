#pragma once

#include "comms/emulator/robot_firmware.h"
#include "core/kinematics/robot_type.h"
#include "core/kinematics/step_motor.h"
#include "resources/robots/open_robot/open_robot.h"

namespace skein::comms {

/// The reference robot of the open protocol, the lines that a microcontroller runs, with motors and a battery.
class OpenFirmware final : public RobotFirmware {
 public:
  explicit OpenFirmware(const core::RobotType& type);

  void receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) override;
  void advance(double dt) noexcept override;
  core::WheelSpeeds wheels() const noexcept override { return {left_.settled_rate(), right_.settled_rate()}; }
  core::WheelSpeeds told() const noexcept override { return told_; }
  std::uint64_t times_told() const noexcept override { return times_told_; }
  double acts_in() const noexcept override;
  void boot() noexcept override;
  void set_battery(double volts) noexcept override { volts_ = volts; }
  void swap_wheels(bool swapped) noexcept override { swapped_ = swapped; }
  void silence_encoders(bool silent) noexcept override { silent_ = silent; }

 private:
  std::uint32_t now() const noexcept { return static_cast<std::uint32_t>(static_cast<std::uint64_t>(1e3 * time_)); }
  void measure() noexcept;
  void drive() noexcept;

  open_robot robot_{};
  std::vector<std::uint8_t>* reply_ = nullptr;  // of the call to receive() under way
  core::StepMotor left_{core::MotorModel::servo}, right_{core::MotorModel::servo};
  core::WheelSpeeds told_;
  std::uint64_t times_told_ = 0;
  std::uint16_t fastest_, track_;
  double time_ = 0.0, volts_ = 7.4;
  bool swapped_ = false, silent_ = false;
};

}  // namespace skein::comms
