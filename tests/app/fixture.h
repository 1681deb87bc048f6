#pragma once

#include <vector>

#include "app/run/operator_command.h"
#include "app/tick/control_tick.h"
#include "core/simulation/simulated_robot.h"

namespace skein::test {

/// The rows of a whole run: simulated robots around the tick on a clock of its own, without session, threads or files.
/// The file's [[operator]] actions are executed. `plant` says what the robots are really made of.
inline std::vector<app::TickRecord> simulate(const app::Experiment& e, const app::Experiment& plant) {
  const auto reference = app::make_reference(e);
  std::vector<core::SimulatedRobot> robots;
  for (std::size_t i = 0; i < e.robots.size(); ++i) {
    robots.emplace_back(plant.robots[i].drive, e.robots[i].motor, e.simulation, e.seed, i);
    robots.back().place(e.robots[i].start.value_or(reference->at(i, 0.0).pose));
  }
  const app::OperatorCommand start = app::commands::Start{};
  std::vector<core::Measurement> measured(robots.size());
  std::vector<core::Pose> truth(robots.size());
  std::vector<app::TickRecord> rows;
  app::ControlTick tick(e);
  std::size_t next_perturbation = 0, next_action = 0;
  std::vector<app::OperatorCommand> commands;
  for (std::int64_t k = 0; k < e.ticks(); ++k) {
    app::TickInput input;
    input.now = static_cast<double>(k) / e.rate;
    for (; next_perturbation < e.perturbations.size(); ++next_perturbation) {
      const app::Perturbation& p = e.perturbations[next_perturbation];
      if (p.t > input.now + 1e-9) break;
      const core::Pose pose = robots[p.robot].pose();
      robots[p.robot].place({pose.x + p.dx, pose.y + p.dy, core::wrap_angle(pose.theta + p.dtheta)});
      input.events.add(app::events::Perturb{p.robot, p.dx, p.dy, p.dtheta});
    }
    commands.clear();
    if (k == 0) commands.push_back(start);
    for (; next_action < e.actions.size() && e.actions[next_action].t <= input.now + 1e-9; ++next_action) {
      const app::Event& event = e.actions[next_action].event;
      if (const auto command = app::command_of(event)) commands.push_back(*command);
      if (const auto* const move = std::get_if<app::events::Move>(&event)) robots[move->robot].place(move->pose);
    }
    for (std::size_t i = 0; i < robots.size(); ++i) {
      measured[i] = robots[i].measure(input.now);
      truth[i] = robots[i].pose();
    }
    input.measurements = measured;
    input.truth = truth;
    input.commands = commands;
    rows.push_back(tick.step(input));
    for (std::size_t i = 0; i < robots.size(); ++i) {
      robots[i].command(rows.back().robots[i].wheels);
      robots[i].step(e.period());
    }
  }
  return rows;
}
inline std::vector<app::TickRecord> simulate(const app::Experiment& e) {
  return simulate(e, e);
}

}  // namespace skein::test
