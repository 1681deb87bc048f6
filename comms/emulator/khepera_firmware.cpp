#include "comms/emulator/khepera_firmware.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace skein::comms {
namespace {

constexpr std::size_t khepera_line = 82;
constexpr double pulses_a_step = 100.0;

}  // namespace

void KheperaFirmware::boot() noexcept {
  line_.clear();
  left_.set_counter(0);
  right_.set_counter(0);
  tell(0, 0);
}

void KheperaFirmware::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) {
  for (const std::uint8_t byte : bytes) {
    if (byte != '\n' && byte != '\r' && line_.size() < khepera_line) {
      line_ += static_cast<char>(byte);
      continue;
    }
    const std::string line = std::exchange(line_, {});
    if (line.empty()) continue;  // an empty line has no answer
    const std::string said = answer(line) + "\r\n";
    reply.insert(reply.end(), said.begin(), said.end());
    return;  // and throws away what has come meanwhile
  }
}

std::string KheperaFirmware::answer(const std::string& line) {
  std::size_t count = 0;
  if (line.size() > 2)
    for (const char* at = line.c_str() + 2; *at != '\0' && count < std::size(arguments_); ++count) {
      char* end = nullptr;
      arguments_[count] = std::strtol(at, &end, 10);
      while (*end != '\0' && *end != ',') ++end;
      at = *end == ',' ? end + 1 : end;
    }
  switch (line.front()) {
    case 'B':
      return "b,A,1";
    case 'D':
      tell(arguments_[0], arguments_[1]);
      return "d";
    case 'E':
      return fmt::format("e,{:.0f},{:.0f}", told_.left, told_.right);
    case 'I':
      left_.set_counter(0);
      right_.set_counter(0);
      return "i";
    case 'M':
      tell(0, 0);
      return "m";
    case 'R':
      return fmt::format("r,{},{}", pulses(swapped_ ? right_ : left_), pulses(swapped_ ? left_ : right_));
    case 'V':
      if (count == 1 && arguments_[0] == 0) return fmt::format("v,{:.0f}", 1e3 * volts_);
      break;
    default:
      break;
  }
  return "$";
}

void KheperaFirmware::tell(long left, long right) noexcept {
  if (swapped_) std::swap(left, right);
  const auto bounded = [&](long speed) { return std::clamp(static_cast<double>(speed), -fastest_, fastest_); };
  told_ = {bounded(left), bounded(right)};
  ++times_told_;
  left_.command(told_.left);
  right_.command(told_.right);
}

long KheperaFirmware::pulses(const core::StepMotor& motor) const noexcept {
  return silent_ ? 0 : std::lround(pulses_a_step * motor.position());
}

}  // namespace skein::comms
