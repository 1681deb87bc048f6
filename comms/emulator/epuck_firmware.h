#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/kinematics/step_rate.h"

namespace skein::comms {

/// What a robot listens to.
enum class Protocol {
  asercom,  ///< Bluetooth, serial line
  wifi      ///< an e-puck2's packets over TCP (epuck_wifi.h)
};

/// The asercom program of an e-puck1 or e-puck2 as a state machine: bytes in, bytes out, byte for byte what the
/// manufacturer's parser answers, mistakes included; or an e-puck2's WiFi program, whose packets become the asercom
/// commands F7 and F8 inside the robot. No I/O, no clock. Not thread-safe.
///
/// Emulated: every request of the protocol that needs no camera, sound, extension board (these are answered as by a
/// robot that lacks them, or pass unanswered). Sensors read constants, but for the battery. The e-puck1's receive ring
/// stands before the parser: see EmulatedEpuck.
class EpuckFirmware {
 public:
  /// `ideal` is an e-puck2 whose motors run exactly the commanded rate.
  explicit EpuckFirmware(core::MotorModel model, Protocol protocol = Protocol::asercom);

  /// Feeds bytes to the parser and appends to `reply` what the robot answers. What is not finished is kept, also when
  /// the host goes away meanwhile.
  void receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply);

  /// The step rates that the motors really run. [steps/s]
  core::WheelSpeeds wheels() const noexcept;

  /// Lets `dt` seconds pass: the encoders count.
  void advance(double dt) noexcept;

  /// What the robot says when it boots; nothing over WiFi.
  std::string greeting() const;
  /// Switches it off and on: wheels stand, counters are 0, the parser is fresh. The greeting is the caller's to send.
  void boot() noexcept;

  /// The parser waits for a new command.
  void forget_half_command() noexcept {
    parsing_ = Parsing::top;
    arguments_.clear();
  }
  Protocol protocol() const noexcept { return protocol_; }

  // Defects: a boot does not mend them.
  void set_battery(double volts) noexcept { battery_volts_ = volts; }         ///< [V]; 3.4 is empty, 4.2 full
  void swap_wheels(bool swapped) noexcept { wheels_swapped_ = swapped; }      ///< left commands drive and count right
  void silence_encoders(bool silent) noexcept { encoders_silent_ = silent; }  ///< counters read 0

 private:
  enum class Parsing { top, line_start, line, sequence, arguments };

  void take(std::uint8_t byte, std::vector<std::uint8_t>& reply);
  void take_packet_byte(std::uint8_t byte, std::vector<std::uint8_t>& reply);
  void run_line(std::vector<std::uint8_t>& reply);
  void run_letter(std::uint8_t letter);
  void run_letter_with_arguments();
  int scan_arguments(int* first, int* second) const;
  void append(std::int64_t value);
  void append_all_sensors();
  void set_motors() noexcept;
  void set_counters(int left, int right) noexcept;
  std::int64_t left_counter() const noexcept { return counter(steps_left_); }
  std::int64_t right_counter() const noexcept { return counter(steps_right_); }
  std::int64_t counter(double position) const noexcept;
  int battery_raw() const noexcept;
  bool epuck1() const noexcept { return model_ == core::MotorModel::epuck1; }

  core::MotorModel model_;
  Protocol protocol_;
  Parsing parsing_ = Parsing::top;
  std::string line_;                     // the ASCII line so far, or finished
  std::vector<std::uint8_t> merged_;     // the answer of the binary sequence so far
  std::uint8_t letter_ = 0;              // the binary command whose arguments are awaited
  std::vector<std::uint8_t> arguments_;  // or the packet so far
  std::size_t arguments_needed_ = 0;

  int speed_left_ = 0, speed_right_ = 0;        // as E reports: last commanded, unclamped
  int position_left_ = 0, position_right_ = 0;  // last arguments of P
  int motor_left_ = 0, motor_right_ = 0;        // what the motors were last told
  double steps_left_ = 0.0, steps_right_ = 0.0;

  double battery_volts_ = 3.9;
  bool wheels_swapped_ = false;
  bool encoders_silent_ = false;
};

}  // namespace skein::comms
