#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comms/emulator/robot_firmware.h"
#include "core/kinematics/step_motor.h"

namespace skein::comms {

/// What a robot listens to.
enum class EpuckProgram {
  asercom,  ///< Bluetooth, serial line
  wifi      ///< an e-puck2's packets over TCP (epuck_wifi.h)
};
/// Whether commands and requests come in whole packets, and the robot streams its measurements.
constexpr bool is_in_packets(EpuckProgram program) noexcept {
  switch (program) {
    case EpuckProgram::asercom:
      return false;
    case EpuckProgram::wifi:
      return true;
  }
  return false;
}

/// The asercom program of an e-puck1 or e-puck2 as a state machine: bytes in, bytes out, with the answers of the
/// manufacturer's parser, bugs included; or an e-puck2's WiFi program, whose packets become the asercom commands F7 and
/// F8 inside the robot. No I/O, no clock. Not thread-safe.
///
/// Emulated: every request of the protocol except those for the camera (I, J), the calibration (K), the scan of the I2C
/// bus (Z) and the whole text of the help (H). Requests to extension boards get the answers of a robot that has none.
/// Sensors read constants, except the battery. The e-puck1's receive ring precedes the parser: see EmulatedEpuck.
class EpuckFirmware final : public RobotFirmware {
 public:
  /// `ideal` is an e-puck2 whose motors run exactly the commanded rate.
  explicit EpuckFirmware(core::MotorModel model, EpuckProgram protocol = EpuckProgram::asercom);

  /// Feeds bytes to the parser and appends to `reply` what the robot answers. Keeps a partial command, even if the host
  /// disconnects. Over WiFi the bytes wait for stream().
  void receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) override;

  /// One round of the WiFi program's loop, every `stream_period`. It takes a command if one waits (only the newest if
  /// there are five or more) and sends its speeds to the motors. After the first command it sends a packet in every
  /// round, of the kind that the newest command requested, whether that command is new or not.
  void stream(std::vector<std::uint8_t>& reply);
  static constexpr double stream_period = 0.022;  // [s]
  bool streams() const noexcept { return streaming_ || !waiting_.empty(); }

  /// The step rates at the speeds last sent to the motors. [steps/s]
  core::WheelSpeeds wheels() const noexcept override {
    return {left_motor_.settled_rate(), right_motor_.settled_rate()};
  }
  /// The speeds last sent to the motors [steps/s], and how often any were sent.
  core::WheelSpeeds told() const noexcept override {
    return {static_cast<double>(motor_left_), static_cast<double>(motor_right_)};
  }
  std::uint64_t times_told() const noexcept override { return times_told_; }

  /// Lets `dt` seconds pass: the encoders count.
  void advance(double dt) noexcept override {
    left_motor_.advance(dt);
    right_motor_.advance(dt);
  }

  /// What the robot says when it boots; nothing over WiFi.
  std::string greeting() const override;
  /// Switches it off and on: wheels stand, counters are 0, the parser is reset. The caller sends the greeting.
  void boot() noexcept override;

  /// Discards a partial command: the parser waits for a new one.
  void forget_half_command() noexcept {
    parsing_ = Parsing::top;
    arguments_.clear();
    waiting_.clear();
    streaming_ = false;
  }
  /// Over WiFi the program starts afresh; asercom does not notice a new host.
  void new_host() noexcept override {
    if (is_in_packets(protocol_)) forget_half_command();
  }
  EpuckProgram protocol() const noexcept { return protocol_; }

  // Defects: a reboot does not clear them.
  void set_battery(double volts) noexcept override { battery_volts_ = volts; }  ///< [V]; 3.4 is empty, 4.2 full
  /// Left commands drive and count right.
  void swap_wheels(bool swapped) noexcept override { wheels_swapped_ = swapped; }
  void silence_encoders(bool silent) noexcept override { encoders_silent_ = silent; }  ///< counters read 0

 private:
  enum class Parsing { top, line_start, line, sequence, arguments };

  void receive_byte(std::uint8_t byte, std::vector<std::uint8_t>& reply);
  void run_line(std::vector<std::uint8_t>& reply);
  void run_letter(std::uint8_t letter, std::vector<std::uint8_t>& reply);
  void run_letter_with_arguments();
  int scan_arguments(int* first, int* second, int* third = nullptr) const;
  void append(std::int64_t value);
  void append_all_sensors();
  void set_motors() noexcept;
  void set_counters(int left, int right) noexcept;
  std::int64_t left_counter() const noexcept { return counter(left_motor_); }
  std::int64_t right_counter() const noexcept { return counter(right_motor_); }
  std::int64_t counter(const core::StepMotor& motor) const noexcept;
  void tell_motors(int left, int right) noexcept;
  int battery_raw() const noexcept;
  bool epuck1() const noexcept { return model_ == core::MotorModel::epuck1; }

  core::MotorModel model_;
  EpuckProgram protocol_;
  Parsing parsing_ = Parsing::top;
  std::string line_;                  // the ASCII line so far, or finished
  std::vector<std::uint8_t> merged_;  // the answer of the binary sequence so far
  std::uint8_t letter_ = 0;           // the binary command whose arguments are awaited
  std::vector<std::uint8_t> arguments_;
  std::size_t arguments_needed_ = 0;

  int speed_left_ = 0, speed_right_ = 0;        // as E reports: last commanded, unclamped
  int position_left_ = 0, position_right_ = 0;  // last arguments of P
  int motor_left_ = 0, motor_right_ = 0;        // the speeds last sent to the motors
  std::uint64_t times_told_ = 0;
  core::StepMotor left_motor_, right_motor_;
  int i2c_module_ = 0, i2c_register_ = 0, i2c_value_ = 0;  // last arguments of Y and W

  std::vector<std::uint8_t> waiting_;  // over WiFi: received and not yet taken
  bool streaming_ = false;             // a first command has come
  bool wants_sensors_ = false;         // the newest command asked for them

  double battery_volts_ = 3.9;
  bool wheels_swapped_ = false;
  bool encoders_silent_ = false;
};

}  // namespace skein::comms
