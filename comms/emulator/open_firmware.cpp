#include "comms/emulator/open_firmware.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace skein::comms {
namespace {

constexpr double step = 1e4;  // steps a metre

}  // namespace

OpenFirmware::OpenFirmware(const core::RobotType& type)
    : fastest_(static_cast<std::uint16_t>(type.wheels.max_step_rate)),
      track_(static_cast<std::uint16_t>(std::lround(step * type.wheels.track))) {
  boot();
}

void OpenFirmware::boot() noexcept {
  open_robot_config config{};
  config.name = "emulated";
  config.fastest = fastest_;
  config.track = track_;
  config.low_battery = 6800;
  config.send = [](void* to, const std::uint8_t* bytes, std::size_t size) {
    if (auto* const reply = static_cast<OpenFirmware*>(to)->reply_) reply->insert(reply->end(), bytes, bytes + size);
  };
  open_robot_begin(&robot_, &config, this);
  left_.set_counter(0);
  right_.set_counter(0);
  drive();
}

void OpenFirmware::measure() noexcept {
  const auto way = [&](const core::StepMotor& motor) {
    return silent_ ? 0 : static_cast<std::int32_t>(static_cast<std::uint32_t>(motor.counter()));
  };
  open_robot_measure(&robot_, way(swapped_ ? right_ : left_), way(swapped_ ? left_ : right_),
                     static_cast<std::uint16_t>(std::lround(1e3 * volts_)));
}

void OpenFirmware::drive() noexcept {
  std::int16_t left = 0, right = 0;
  open_robot_wheels(&robot_, now(), &left, &right);
  if (swapped_) std::swap(left, right);
  const core::WheelSpeeds told{static_cast<double>(left), static_cast<double>(right)};
  if (told == told_) return;
  told_ = told;
  ++times_told_;
  left_.command(told.left);
  right_.command(told.right);
}

void OpenFirmware::receive(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& reply) {
  measure();
  reply_ = &reply;
  open_robot_hear(&robot_, bytes.data(), bytes.size(), now());
  reply_ = nullptr;
  drive();
}

void OpenFirmware::advance(double dt) noexcept {
  // The watchdog bites in between.
  const double first = std::min(dt, acts_in());
  for (const double part : {first, dt - first}) {
    left_.advance(part);
    right_.advance(part);
    time_ += part;
    drive();
  }
}

double OpenFirmware::acts_in() const noexcept {
  if (robot_.left == 0 && robot_.right == 0) return RobotFirmware::acts_in();
  const auto left = static_cast<std::int32_t>(robot_.commanded_at + OPEN_ROBOT_WATCHDOG_MS - now());
  return std::max(1e-3 * left, 1e-3);  // its clock counts milliseconds
}

}  // namespace skein::comms
