#include "comms/emulator/epuck_firmware.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>

namespace skein::comms {
namespace {

// What the sensors read: a robot alone on a table. The arguments of "S" and the LEDs change nothing that can be read.
constexpr std::array<int, 8> proximity{12, 9, 15, 11, 10, 14, 8, 13};
constexpr std::array<int, 8> ambient{3900, 3905, 3898, 3910, 3902, 3897, 3908, 3901};
constexpr std::array<int, 3> acceleration{2048, 2050, 2870};
constexpr int selector = 3;
constexpr int battery_raw_epuck2 = 3195;  // 3.9 V * 819.2
constexpr int battery_percent_epuck2 = 62;

constexpr std::string_view welcome =
    "\f\aWELCOME to the SerCom protocol on e-Puck\r\nthe EPFL education robot type \"H\" for help\r\n";

// The firmware's buffer has room for a small camera image; what a longer line overwrites there is not for us to say.
constexpr std::size_t longest_line = 3200;

template <std::size_t N>
std::string list(char letter, const std::array<int, N>& values) {
  std::string line(1, letter);
  for (const int value : values) line += fmt::format(",{}", value);
  return line + "\r\n";
}

int as_int16(int value) {
  return static_cast<std::int16_t>(value);
}

}  // namespace

EpuckFirmware::EpuckFirmware(core::MotorModel model) : model_(model) {}

void EpuckFirmware::boot() noexcept {
  *this = EpuckFirmware(model_);
}

std::string EpuckFirmware::greeting() const {
  return (epuck1() ? fmt::format("Selector pos {}\r\n", selector) : "") + std::string(welcome);
}

// --- The parser -----------------------------------------------------------------------------------------------------

void EpuckFirmware::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) {
  for (const std::uint8_t byte : bytes) take(byte, reply);
}

// The firmware is one thread that waits for every byte; here each place where it waits is a state.
void EpuckFirmware::take(std::uint8_t byte, std::vector<std::uint8_t>& reply) {
  const bool ends_line = byte == '\n' || byte == '\r';
  switch (parsing_) {
    case Parsing::top:
      if (byte == 0) return;
      if (byte >= 0x80) {  // a negative char: binary
        merged_.clear();
        run_letter(byte);
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
      if (line_.size() < longest_line) line_.push_back(static_cast<char>(byte));
      if (!ends_line) return;
      parsing_ = Parsing::top;
      run_line(reply);
      return;
    case Parsing::sequence:
      if (byte != 0) return run_letter(byte);
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
int EpuckFirmware::scan_arguments(int* first, int* second) const {
  const std::string_view text = std::string_view(line_).substr(0, line_.find('\0'));  // a C string ends there
  std::size_t at = 1;
  int count = 0;
  for (int* const value : {first, second}) {
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
      answer = fmt::format("q,{},{}\r\n", counter(steps_left_), counter(steps_right_));
      break;
    case 'S':  // the motors only: E goes on reporting the old speeds
      motor_left_ = motor_right_ = 0;
      answer = "s\r\n";
      break;
    case 'V':
      answer = epuck1() ? "v,Version 1.2.2 August 2008 GCtronic\r\n" : "v,Version 2.0 January 2018 GCtronic\r\n";
      answer += "HW version: FFFF\r\n";
      break;
    case 'b':  // an e-puck1 before hardware 1.3 knows only good and low
      answer = epuck1() ? "b,1\r\n" : fmt::format("b,{} ({}%)\r\n", battery_raw_epuck2, battery_percent_epuck2);
      break;
    case 'A':
      answer = list('a', acceleration);
      break;
    case 'C':
      answer = fmt::format("c,{}\r\n", selector);
      break;
    case 'N':
      answer = list('n', proximity);
      break;
    case 'O':
      answer = list('o', ambient);
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
    case 'I':
    case 'J':
    case 'K':
    case 'W':
    case 'Y':
    case 'Z':  // camera, calibration, I2C: not emulated, not answered
      break;
    default:
      answer = "z,Command not found\r\n";
  }
  reply.insert(reply.end(), answer.begin(), answer.end());
}

// --- Binary ---------------------------------------------------------------------------------------------------------

void EpuckFirmware::append(std::int64_t value) {
  merged_.push_back(static_cast<std::uint8_t>(value & 0xFF));
  merged_.push_back(static_cast<std::uint8_t>((value >> 8) & 0xFF));
}

void EpuckFirmware::run_letter(std::uint8_t letter) {
  parsing_ = Parsing::sequence;
  letter_ = letter;
  arguments_.clear();
  arguments_needed_ = 0;
  if (letter < 0x80) return;  // a positive char inside a sequence: ignored
  switch (256 - letter) {
    case 'D':
    case 'P':
      arguments_needed_ = 4;
      break;
    case 'L':
      arguments_needed_ = 2;
      break;
    case 'W':
      arguments_needed_ = 3;
      break;
    case 'w':
      arguments_needed_ = 35;
      break;
    case 'Q':
      append(counter(steps_left_));
      append(counter(steps_right_));
      break;
    case 'E':
      append(speed_left_);
      append(speed_right_);
      break;
    case 'a':
      for (const int value : acceleration) append(value);
      break;
    case 'b':
      append(epuck1() ? 1 : battery_raw_epuck2);
      break;
    case 'N':
      for (const int value : proximity) append(value);
      break;
    case 'O':
      for (const int value : ambient) append(value);
      break;
    case 't':
      merged_.push_back(0);
      break;
    case 'g':
    case 'u':
      merged_.insert(merged_.end(), 6, 0);
      break;
    case 0x8:  // all sensors at once
      if (!epuck1()) append_all_sensors();
      break;
    case 0x9:  // all actuators at once
      if (!epuck1()) arguments_needed_ = 19;
      break;
    case 0xA:  // coloured LEDs
      if (!epuck1()) arguments_needed_ = 12;
      break;
    default:  // unknown or not emulated: passed over in silence
      break;
  }
  if (arguments_needed_ > 0) parsing_ = Parsing::arguments;
}

void EpuckFirmware::run_letter_with_arguments() {
  // An e-puck2 puts the bytes together in 32 bits without a sign: -100 is 65436 there, until the motors take 16 bits of
  // it. An e-puck1's int has 16 bits.
  const auto argument = [this](std::size_t at) {
    const int value = arguments_[at] + (arguments_[at + 1] << 8);
    return epuck1() ? as_int16(value) : value;
  };
  switch (256 - letter_) {
    case 'D':
      speed_left_ = argument(0);
      speed_right_ = argument(2);
      set_motors();
      break;
    case 'P':
      position_left_ = argument(0);
      position_right_ = argument(2);
      set_counters(position_left_, position_right_);
      break;
    case 0x9:
      speed_left_ = argument(1);
      speed_right_ = argument(3);
      if ((arguments_[0] & 0x04) == 0) set_motors();  // else they are positions, which an e-puck2 cannot set
      break;
    default:
      break;
  }
}

// 103 bytes in the firmware's order; what a robot alone does not sense is 0.
void EpuckFirmware::append_all_sensors() {
  constexpr std::size_t whole = 103, before_proximity = 37, before_encoders = 79;
  const std::size_t start = merged_.size();
  for (const int value : acceleration) append(value);
  merged_.resize(start + before_proximity);  // spherical acceleration, gyroscope, magnetic field, temperature
  for (const int value : proximity) append(value);
  for (const int value : ambient) append(value);
  merged_.resize(start + before_encoders);  // distance, microphones
  append(counter(steps_left_));
  append(counter(steps_right_));
  append(battery_raw_epuck2);
  merged_.insert(merged_.end(), 4, 0);  // memory card, remote control
  merged_.push_back(selector);
  merged_.resize(start + whole);  // ground sensors
}

// --- Wheels ---------------------------------------------------------------------------------------------------------

void EpuckFirmware::set_motors() noexcept {
  motor_left_ = as_int16(speed_left_);
  motor_right_ = as_int16(speed_right_);
}

void EpuckFirmware::set_counters(int left, int right) noexcept {
  if (!epuck1()) return;  // an e-puck2 says that it did
  steps_left_ = left;
  steps_right_ = right;
}

core::WheelSpeeds EpuckFirmware::wheels() const noexcept {
  return {core::actual_step_rate(model_, motor_left_), core::actual_step_rate(model_, motor_right_)};
}

void EpuckFirmware::advance(double dt) noexcept {
  const core::WheelSpeeds rates = wheels();
  steps_left_ += rates.left * dt;
  steps_right_ += rates.right * dt;
}

std::int64_t EpuckFirmware::counter(double position) const noexcept {
  // Whole steps only, a hair's breadth of rounding forgiven: 25 times 0.04 s at 1000 steps/s are 1000 steps, not 999.
  const auto steps = static_cast<std::int64_t>(position + std::copysign(1e-6, position));
  return epuck1() ? static_cast<std::int16_t>(steps) : static_cast<std::int32_t>(steps);
}

}  // namespace skein::comms
