// The binary half of the emulated firmware; the parser that leads here is in epuck_firmware.cpp.
#include <algorithm>

#include "comms/emulator/epuck_firmware.h"
#include "comms/emulator/epuck_values.h"

namespace skein::comms {

// A packet: its head, what is asked for, then the arguments of "all actuators at once". What begins with another byte
// is passed over.
void EpuckFirmware::stream(std::vector<std::uint8_t>& reply) {
  constexpr std::size_t whole = 21, too_many = 5;
  if (!is_in_packets(protocol_)) return;
  while (!waiting_.empty() && waiting_.front() != 0x80) waiting_.erase(waiting_.begin());
  const std::size_t packets = waiting_.size() / whole;
  if (packets >= too_many)
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>((packets - 1) * whole));
  if (waiting_.size() >= whole) {
    wants_sensors_ = (waiting_[1] & 0x02) != 0;
    arguments_.assign(waiting_.begin() + 2, waiting_.begin() + whole);
    letter_ = 0xF7;
    run_letter_with_arguments();
    arguments_.clear();
    waiting_.erase(waiting_.begin(), waiting_.begin() + whole);
    streaming_ = true;
  }
  if (!streaming_) return;
  reply.push_back(wants_sensors_ ? 0x02 : 0x03);
  if (!wants_sensors_) return;
  merged_.clear();
  append_all_sensors();
  merged_.push_back(0);  // one that means nothing
  reply.insert(reply.end(), merged_.begin(), merged_.end());
}

// The firmware receives a byte where an int lies.
static void set_low_byte(int& value, std::uint8_t byte) {
  value = (value & ~0xFF) | byte;
}

void EpuckFirmware::append(std::int64_t value) {
  merged_.push_back(static_cast<std::uint8_t>(value & 0xFF));
  merged_.push_back(static_cast<std::uint8_t>((value >> 8) & 0xFF));
}

void EpuckFirmware::run_letter(std::uint8_t letter, std::vector<std::uint8_t>& reply) {
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
      append(left_counter());
      append(right_counter());
      break;
    case 'E':
      append(speed_left_);
      append(speed_right_);
      break;
    case 'a':
      for (const int value : epuck_alone.acceleration) append(value);
      break;
    case 'b':
      append(battery_raw());
      break;
    case 'N':
      for (const int value : epuck_alone.proximity) append(value);
      break;
    case 'O':
      for (const int value : epuck_alone.ambient) append(value);
      break;
    case 'A':  // spherical, three numbers of 4 bytes
      merged_.insert(merged_.end(), 12, 0);
      break;
    case 'M':  // no ground sensors
      merged_.insert(merged_.end(), epuck1() ? 10 : 8, 0);
      break;
    case 'U':  // an e-puck1 sends its microphones' buffer at once, ahead of the merged answer
      if (!epuck1()) break;
      reply.insert(reply.end(), 600, 0);
      merged_.push_back(0);
      break;
    case 'Y':
      if (!epuck1()) arguments_needed_ = 2;
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
    case 0xB:  // the button
    case 0xE:  // the memory card
      if (!epuck1()) merged_.push_back(0);
      break;
    case 0xC:  // four microphones
      if (!epuck1()) merged_.insert(merged_.end(), 8, 0);
      break;
    case 0xD:  // distance
      if (!epuck1()) merged_.insert(merged_.end(), 2, 0);
      break;
    case 0xF:   // magnetometer on, off
    case 0x10:  // proximity on, off
    case 0x11:  // distance on, off
      if (!epuck1()) arguments_needed_ = 1;
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
      if ((arguments_[0] & 0x04) == 0)
        set_motors();
      else
        set_counters(speed_left_, speed_right_);
      break;
    case 0xF:
    case 0x10:
    case 0x11:  // done
      merged_.push_back(0);
      break;
    case 'Y':  // nobody is on the bus
    case 'W':
      set_low_byte(i2c_module_, arguments_[0]);
      set_low_byte(i2c_register_, arguments_[1]);
      if (letter_ == 256 - 'Y') merged_.push_back(0);
      break;
    case 'w':  // an e-puck1 receives its arguments where it puts its answer together
      if (epuck1()) std::copy_n(arguments_.begin(), std::min(arguments_.size(), merged_.size()), merged_.begin());
      break;
    default:
      break;
  }
}

// 103 bytes in the firmware's order; what a robot alone does not sense is 0.
void EpuckFirmware::append_all_sensors() {
  constexpr std::size_t whole = 103, before_proximity = 37, before_encoders = 79;
  const std::size_t start = merged_.size();
  for (const int value : epuck_alone.acceleration) append(value);
  merged_.resize(start + before_proximity);  // spherical acceleration, gyroscope, magnetic field, temperature
  for (const int value : epuck_alone.proximity) append(value);
  for (const int value : epuck_alone.ambient) append(value);
  merged_.resize(start + before_encoders);  // distance, microphones
  append(left_counter());
  append(right_counter());
  append(battery_raw());
  merged_.insert(merged_.end(), 4, 0);  // memory card, remote control
  merged_.push_back(epuck_alone.selector);
  merged_.resize(start + whole);  // ground sensors
}

}  // namespace skein::comms
