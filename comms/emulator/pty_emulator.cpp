#include "comms/emulator/pty_emulator.h"

#include <utility>

#include "comms/emulator/make_firmware.h"

namespace skein::comms {
namespace {

std::vector<EmulatorLoop::Robot> on_lines(const std::vector<core::MotorModel>& models, DeviceNames& names) {
  std::vector<EmulatorLoop::Robot> robots;
  for (std::size_t i = 0; i < models.size(); ++i)
    robots.push_back({models[i], EpuckProgram::asercom, make_pty_endpoint(names, i)});
  return robots;
}

std::vector<EmulatorLoop::Robot> on_lines(const std::vector<const core::RobotType*>& types, DeviceNames& names) {
  std::vector<EmulatorLoop::Robot> robots;
  for (std::size_t i = 0; i < types.size(); ++i)
    robots.push_back({types[i]->motor, EpuckProgram::asercom, make_pty_endpoint(names, i), make_firmware(*types[i])});
  return robots;
}

}  // namespace

PtyEmulator::PtyEmulator(const std::vector<core::MotorModel>& robots, WheelsTold on_wheels,
                         std::function<double()> clock, std::string directory, const std::vector<Fault>& faults,
                         std::uint64_t seed)
    : names_(std::move(directory)),
      loop_(on_lines(robots, names_), std::move(on_wheels), std::move(clock), faults, seed) {}

PtyEmulator::PtyEmulator(const std::vector<const core::RobotType*>& robots, WheelsTold on_wheels,
                         std::function<double()> clock, std::string directory, const std::vector<Fault>& faults,
                         std::uint64_t seed)
    : names_(std::move(directory)),
      loop_(on_lines(robots, names_), std::move(on_wheels), std::move(clock), faults, seed) {}

std::string PtyEmulator::device(std::size_t robot) const {
  return names_.name(robot);
}

}  // namespace skein::comms
