#include "app/experiment/rehearsal.h"

#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "app/experiment/experiment_file.h"
#include "app/experiment/hardware.h"
#include "app/experiment/toml_places.h"

namespace skein::app {

tl::expected<Experiment, std::vector<Problem>> rehearsal(const Experiment& experiment) {
  if (!has_hardware(experiment)) return experiment;
  std::vector<std::string> sets{"name=" + toml_string(experiment.name + " (rehearsal)")};
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const RobotSpec& robot = experiment.robots[i];
    if (!robot.is_real()) continue;
    sets.push_back(fmt::format("robot.{}.link=\"loopback\"", i + 1));
    sets.push_back(fmt::format("robot.{}.model=\"{}\"", i + 1, robot.type->name));  // its real link implied it
  }
  for (std::size_t number = 0; number < experiment.cameras() && is_hardware(experiment.camera.kind()); ++number) {
    const std::string table = number == 0 ? "camera" : fmt::format("camera.also.{}", number);
    const double latency = experiment.camera_at(number).latency;
    sets.push_back(table + ".source=\"synthetic\"");
    sets.push_back(table + ".trigger=\"\"");
    if (latency > 0.0) sets.push_back(fmt::format("{}.stamps_late={}", table, latency));
    if (latency < 0.0) sets.push_back(table + ".latency=0.0");  // no picture comes before what it shows
  }
  const std::filesystem::path file = std::filesystem::path(experiment.directory) / "rehearsal.toml";
  return parse_experiment(experiment.source, file.string(), sets);
}

}  // namespace skein::app
