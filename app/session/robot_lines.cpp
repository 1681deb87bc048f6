#include "app/session/robot_lines.h"

#include "app/guard/safety_net.h"

namespace skein::app {

tl::expected<RobotLines, std::string> open_lines(
    const Experiment& experiment,
    const std::function<void(std::size_t robot, const core::WheelSpeeds& told)>& on_wheels,
    const std::function<double()>& clock, const std::vector<comms::Fault>& faults) {
  RobotLines lines;
  std::vector<const core::RobotType*> types;
  std::vector<std::size_t> emulated;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    if (!experiment.robots[i].has_link()) continue;
    lines.robots.push_back(i);
    if (experiment.robots[i].is_real()) continue;
    types.push_back(experiment.robots[i].type);
    emulated.push_back(i);
  }
  if (!types.empty())
    lines.emulator = std::make_unique<comms::PtyEmulator>(
        types, [on_wheels, emulated](std::size_t k, const core::WheelSpeeds& told) { on_wheels(emulated[k], told); },
        clock, std::string{}, faults, experiment.seed);
  std::size_t next_emulated = 0;
  for (const std::size_t i : lines.robots) {
    if (experiment.robots[i].is_real()) {
      auto address = link_of(experiment, i);
      if (!address) return tl::unexpected(address.error());
      lines.addresses.push_back(*address);
      continue;
    }
    const comms::LinkAddress line{
        comms::LinkKind::serial, lines.emulator->device(next_emulated++), 0, {}, robot_name(experiment, i)};
    lines.addresses.push_back(*comms::spoken_by(line, experiment.robots[i].type->protocol));
  }
  return lines;
}

}  // namespace skein::app
