#include "comms/emulator/pty_emulator.h"

#include <utility>

namespace skein::comms {
namespace {

std::vector<std::unique_ptr<Endpoint>> endpoints(DeviceNames& names, std::size_t robots) {
  std::vector<std::unique_ptr<Endpoint>> all;
  for (std::size_t i = 0; i < robots; ++i) all.push_back(make_pty_endpoint(names, i));
  return all;
}

}  // namespace

PtyEmulator::PtyEmulator(const std::vector<core::MotorModel>& robots, WheelsChanged on_wheels,
                         std::function<double()> clock, std::string directory, const std::vector<Fault>& faults,
                         std::uint64_t seed)
    : names_(std::move(directory)),
      loop_(robots, endpoints(names_, robots.size()), std::move(on_wheels), std::move(clock), faults, seed) {}

std::string PtyEmulator::device(std::size_t robot) const {
  return names_.name(robot);
}

}  // namespace skein::comms
