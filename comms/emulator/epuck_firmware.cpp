#include "comms/emulator/epuck_firmware.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "comms/emulator/epuck_values.h"

namespace skein::comms {
namespace {

constexpr std::string_view welcome =
    "\f\aWELCOME to the SerCom protocol on e-Puck\r\nthe EPFL education robot type \"H\" for help\r\n";

// The firmware's buffer has room for a small camera image; what a longer line overwrites there is not for us to say.
constexpr std::size_t text_buffer = 3200;

constexpr double empty_battery = 3.4, full_battery = 4.2;  // [V]
constexpr double raw_per_volt = 819.2;                     // of an e-puck2

int battery_percent(double volts) {
  return static_cast<int>(100.0 * std::clamp((volts - empty_battery) / (full_battery - empty_battery), 0.0, 1.0));
}

template <std::size_t N>
std::string list(char letter, const std::array<int, N>& values) {
  std::string line(1, letter);
  for (const int value : values) line += fmt::format(",{}", value);
  return line + "\r\n";
}

}  // namespace

EpuckFirmware::EpuckFirmware(core::MotorModel model, EpuckProgram protocol)
    : model_(model), protocol_(protocol), left_motor_(model), right_motor_(model) {}

void EpuckFirmware::boot() noexcept {
  EpuckFirmware fresh(model_, protocol_);
  fresh.battery_volts_ = battery_volts_;
  fresh.wheels_swapped_ = wheels_swapped_;
  fresh.encoders_silent_ = encoders_silent_;
  fresh.times_told_ = times_told_ + 1;
  *this = std::move(fresh);
}

std::string EpuckFirmware::greeting() const {
  if (is_in_packets(protocol_)) return {};
  return (epuck1() ? fmt::format("Selector pos {}\r\n", epuck_alone.selector) : "") + std::string(welcome);
}

// --- The parser -----------------------------------------------------------------------------------------------------

void EpuckFirmware::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) {
  if (is_in_packets(protocol_))
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  else
    for (const std::uint8_t byte : bytes) receive_byte(byte, reply);
}

// The firmware is one thread that waits for every byte; here each place where it waits is a state.
void EpuckFirmware::receive_byte(std::uint8_t byte, std::vector<std::uint8_t>& reply) {
  const bool ends_line = byte == '\n' || byte == '\r';
  switch (parsing_) {
    case Parsing::top:
      if (byte == 0) return;
      if (byte >= 0x80) {  // a negative char: binary
        merged_.clear();
        run_letter(byte, reply);
        return;
      }
      line_.assign(ends_line ? "" : std::string(1, static_cast<char>(byte)));
      parsing_ = ends_line ? Parsing::line_start : Parsing::line;
      return;
    case Parsing::line_start:  // leading line ends are skipped; whatever follows begins a line, even a binary byte
      if (ends_line) return;
      line_.assign(1, static_cast<char>(byte));
      parsing_ = Parsing::line;
      return;
    case Parsing::line:
      if (line_.size() < text_buffer) line_.push_back(static_cast<char>(byte));
      if (!ends_line) return;
      parsing_ = Parsing::top;
      run_line(reply);
      return;
    case Parsing::sequence:
      if (byte != 0) return run_letter(byte, reply);
      reply.insert(reply.end(), merged_.begin(), merged_.end());
      parsing_ = Parsing::top;
      return;
    case Parsing::arguments:
      arguments_.push_back(byte);
      if (arguments_.size() < arguments_needed_) return;
      parsing_ = Parsing::sequence;
      run_letter_with_arguments();
      return;
  }
}

// --- ASCII ----------------------------------------------------------------------------------------------------------

// Reads ",number,number" as the firmware's sscanf does: a number that is not there leaves its variable as it was, and
// so does everything after it.
int EpuckFirmware::scan_arguments(int* first, int* second, int* third) const {
  const std::string_view text = std::string_view(line_).substr(0, line_.find('\0'));  // a C string ends there
  std::size_t at = 1;
  int count = 0;
  for (int* const value : {first, second, third}) {
    if (value == nullptr || at >= text.size() || text[at] != ',') return count;
    ++at;
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
    const bool negative = at < text.size() && text[at] == '-';
    if (at < text.size() && (text[at] == '-' || text[at] == '+')) ++at;
    if (at >= text.size() || !std::isdigit(static_cast<unsigned char>(text[at]))) return count;
    std::uint32_t digits = 0;
    for (; at < text.size() && std::isdigit(static_cast<unsigned char>(text[at])); ++at)
      digits = digits * 10 + static_cast<std::uint32_t>(text[at] - '0');
    *value = static_cast<int>(negative ? 0u - digits : digits);
    if (epuck1()) *value = as_int16(*value);  // its int has 16 bits
    ++count;
  }
  return count;
}

void EpuckFirmware::run_line(std::vector<std::uint8_t>& reply) {
  char letter = line_[0];
  if (letter != 'b' && letter != 'g') letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
  std::string answer;
  switch (letter) {
    case 'D':
      scan_arguments(&speed_left_, &speed_right_);
      set_motors();
      answer = "d\r\n";
      break;
    case 'E':
      answer = fmt::format("e,{},{}\r\n", speed_left_, speed_right_);
      break;
    case 'P':
      scan_arguments(&position_left_, &position_right_);
      set_counters(position_left_, position_right_);
      answer = "p\r\n";
      break;
    case 'Q':
      answer = fmt::format("q,{},{}\r\n", left_counter(), right_counter());
      break;
    case 'S':  // the motors only: E goes on reporting the old speeds
      tell_motors(0, 0);
      answer = "s\r\n";
      break;
    case 'V':
      answer = epuck1() ? "v,Version 1.2.2 August 2008 GCtronic\r\n" : "v,Version 2.0 January 2018 GCtronic\r\n";
      answer += "HW version: FFFF\r\n";
      break;
    case 'b':
      answer = epuck1() ? fmt::format("b,{}\r\n", battery_raw())
                        : fmt::format("b,{} ({}%)\r\n", battery_raw(), battery_percent(battery_volts_));
      break;
    case 'A':
      answer = list('a', epuck_alone.acceleration);
      break;
    case 'C':
      answer = fmt::format("c,{}\r\n", epuck_alone.selector);
      break;
    case 'N':
      answer = list('n', epuck_alone.proximity);
      break;
    case 'O':
      answer = list('o', epuck_alone.ambient);
      break;
    case 'U':
      answer = "u,0,0,0\r\n";
      break;
    case 'M':
      answer = "m,0,0,0,0,0\r\n";
      break;
    case 'g':
      answer = "g,0,0,0\r\n";
      break;
    case 'G':
      answer = "g IR check : 0x0, address : 0x0, data : 0x0\r\n";
      break;
    case 'L':
    case 'B':
    case 'F':
    case 'T':
      answer = std::string(1, static_cast<char>(std::tolower(letter))) + "\r\n";
      break;
    case 'H':  // the robot's own text is longer
      answer =
          "\n\"D,#,#\"           Set motor speed left,right\r\n\"Q\"               Get motor position\r\n"
          "\"S\"               Stop e-puck and turn off leds\r\n";
      break;
    case 'R':
      if (!epuck1()) break;  // an e-puck2 knows the letter and does nothing
      boot();
      answer = "r\r\n" + greeting();
      break;
    case 'W':
      scan_arguments(&i2c_module_, &i2c_register_, &i2c_value_);
      answer = "w\r\n";
      break;
    case 'Y':  // nobody is on the bus
      scan_arguments(&i2c_module_, &i2c_register_);
      answer = fmt::format("y,{},{}\r\ny,0\r\n", i2c_module_, i2c_register_);
      i2c_value_ = 0;
      break;
    case 'I':
    case 'J':
    case 'K':
    case 'Z':  // camera, calibration, all of the I2C bus: not emulated, not answered
      break;
    default:
      answer = "z,Command not found\r\n";
  }
  reply.insert(reply.end(), answer.begin(), answer.end());
}

// --- Wheels ---------------------------------------------------------------------------------------------------------

void EpuckFirmware::set_motors() noexcept {
  const int left = as_int16(speed_left_), right = as_int16(speed_right_);
  if (wheels_swapped_)
    tell_motors(right, left);
  else
    tell_motors(left, right);
}

void EpuckFirmware::tell_motors(int left, int right) noexcept {
  motor_left_ = left;
  motor_right_ = right;
  ++times_told_;
  left_motor_.command(left);
  right_motor_.command(right);
}

void EpuckFirmware::set_counters(int left, int right) noexcept {
  left_motor_.set_counter(left);
  right_motor_.set_counter(right);
}

int EpuckFirmware::battery_raw() const noexcept {
  // An e-puck1 before hardware 1.3 knows only good and low.
  if (epuck1()) return battery_volts_ >= empty_battery ? 1 : 0;
  return static_cast<int>(std::lround(battery_volts_ * raw_per_volt));
}

std::int64_t EpuckFirmware::counter(const core::StepMotor& motor) const noexcept {
  if (encoders_silent_) return 0;
  const std::int64_t steps = motor.counter();
  return epuck1() ? static_cast<std::int16_t>(steps) : static_cast<std::int32_t>(steps);
}

}  // namespace skein::comms
