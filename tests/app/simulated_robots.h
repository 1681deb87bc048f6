#pragma once

#include <cstddef>
#include <vector>

#include "app/experiment/experiment.h"
#include "core/simulation/simulated_robot.h"

namespace skein::test {

/// An experiment's robots, simulated, each where its reference begins.
inline std::vector<core::SimulatedRobot> robots_at_their_references(const app::Experiment& experiment) {
  std::vector<core::SimulatedRobot> robots;
  const auto reference = app::make_reference(experiment);
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const auto& robot = experiment.robots[i];
    robots.emplace_back(robot.drive, robot.motor, experiment.simulation, experiment.seed, i);
    robots.back().place(reference->at(i, 0.0).pose);
  }
  return robots;
}

}  // namespace skein::test
