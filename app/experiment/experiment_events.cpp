#include "app/experiment/experiment_events.h"

#include <fmt/format.h>

#include <cmath>

#include "app/experiment/experiment_robots.h"
#include "app/experiment/longest.h"
#include "core/avoidance/obstacle.h"
#include "core/geometry/pose.h"

namespace skein::app {
namespace {

void read_perturbations(TomlTable& document, Experiment& e) {
  const auto robots = static_cast<std::int64_t>(document.sound("robot") ? e.robots.size() : most_robots);
  for (TomlTable& t : document.tables("perturb")) {
    Perturbation p;
    std::int64_t robot = 1;
    t.require("t", "the time in s");
    t.number("t", p.t, between(0.0, longest_run, "s"));
    t.require("robot", fmt::format("the robot to move, from 1 to {}", robots));
    t.integer("robot", robot, 1, robots);
    p.robot = static_cast<std::size_t>(robot - 1);
    t.number("dx", p.dx, between(-e.arena_width, e.arena_width, "m"));
    t.number("dy", p.dy, between(-e.arena_height, e.arena_height, "m"));
    t.number("dtheta", p.dtheta, between(-full_turn, full_turn, "rad"));
    if (!t.has("dx") && !t.has("dy") && !t.has("dtheta")) t.require("dx", "at least one of dx, dy, dtheta");
    t.finish();
    e.perturbations.push_back(p);
  }
}

void read_actions(TomlTable& document, Experiment& e) {
  for (TomlTable& t : document.tables("operator")) {
    OperatorAction action;
    std::string words;
    t.require("t", "the time in s");
    t.number("t", action.t, between(0.0, longest_run, "s"));
    t.require("does", "the action, such as \"kick r2 vx=0.3 vy=0\"");
    t.text("does", words);
    if (const auto event = parse_action(words))
      action.event = *event;
    else if (const toml::node* const found = t.node("does"); found != nullptr && found->is_string())
      t.refuse("does", *found,
               "\"move r1 x=0 y=0 theta=0\", \"kick r1 vx=0.3 vy=0\", \"hold r1\", \"release r1\", "
               "\"obstacle o1 x=0 y=0 radius=0.05\", \"gain k_xx 0.008 -> 0.01\", "
               "\"pair_gain r1 r2 k_xx 0.008 -> 0.01\", \"parameter alpha_l 0.8 -> 1.5\", \"uncouple r1 r2\" or "
               "\"couple r1 r2\"");
    t.finish();
    e.actions.push_back(action);
  }
}

void check_perturbations(const Experiment& e, Problems& problems) {
  for (std::size_t i = 0; i < e.perturbations.size(); ++i) {
    const Perturbation& p = e.perturbations[i];
    if (p.robot < e.robots.size() && !e.robots[p.robot].simulated())
      problems.add(fmt::format("perturb.{}.robot", i + 1),
                   fmt::format("found {}, a real robot (link \"{}\"), allowed: a simulated one; move real ones by hand",
                               p.robot + 1, e.robots[p.robot].address));
  }
}

/// What an action names has to be there, and what it does has to be possible. The answer says what is allowed; empty:
/// the action is.
std::string wrong_with(const Event& action, const Experiment& e) {
  const std::size_t robots = e.robots.size();
  const LawSpec& law = e.controller.law;
  const std::size_t most_obstacles = e.obstacles.size() + core::ObstacleField::room_for_more;
  const auto robot = [&](std::size_t i) { return i < robots ? "" : fmt::format("a robot, r1 to r{}", robots); };
  const auto simulated = [&](std::size_t i) {
    if (i >= robots || e.robots[i].simulated()) return std::string(robot(i));
    return fmt::format("a simulated robot; robot {} is real: move it by hand", i + 1);
  };
  const auto pair = [&](std::size_t i, std::size_t j) {
    return i < robots && j < robots && i != j ? "" : fmt::format("two different robots, r1 to r{}", robots);
  };
  const auto gain = [](core::GainName name, double to) {
    return name <= core::gain_names.back() && to >= 0.0
               ? ""
               : std::string("k_xx, k_tt or k_yy, and a value of 0 or more behind ->");
  };
  using namespace events;
  return std::visit(
      Overloaded{
          [&](const one_of<Move, Kick> auto& a) -> std::string { return simulated(a.robot); },
          [&](const one_of<Hold, Release> auto& a) -> std::string { return robot(a.robot); },
          [&](const one_of<Couple, Uncouple> auto& a) -> std::string { return pair(a.i, a.j); },
          [&](const Gain& a) -> std::string { return gain(a.gain, a.to); },
          [&](const PairGain& a) -> std::string {
            const std::string wrong = pair(a.i, a.j);
            return wrong.empty() ? gain(a.gain, a.to) : wrong;
          },
          [&](const Parameter& a) -> std::string {
            // What a controller of the user's own allows is known when it is started.
            return law.own() ? "" : wrong_parameter(declared_parameters(law), a.name.text(), a.to);
          },
          [&](const PutObstacle& a) -> std::string {
            const auto& [x, y, radius] = a.obstacle;
            if (a.number >= most_obstacles)
              return fmt::format("obstacles o1 to o{}: the file's come first", most_obstacles);
            const bool on_floor = std::abs(x) <= e.arena_width / 2 && std::abs(y) <= e.arena_height / 2;
            if (radius == 0.0 || (radius > 0.0 && on_floor)) return {};
            return "a place inside the arena, and a radius of 0, which removes it, or more";
          },
          // No actions: `parse_action` does not read them.
          [](const one_of<Start, Pause, Resume, Stop, Perturb, Kidnap, Schedule, ScheduleTracking, GainHeld,
                          PairGainHeld, Lost, Found, Avoid, Clear, events::Stage, Staged, Deadlock, NoWay, NoProgress,
                          Outside, DeadlineMissed, VRise, Link, CameraMoved, PicturesLate, CamerasDisagree,
                          CamerasDiffer, CameraLost, CameraFound, events::NotSeen, FilmBroken, Controller, NoNumber,
                          Runaway, Obeys> auto&) -> std::string { return {}; },
      },
      action);
}

void check_actions(const Experiment& e, Problems& problems) {
  for (std::size_t k = 0; k < e.actions.size(); ++k) {
    const Event& event = e.actions[k].event;
    if (const std::string allowed = wrong_with(event, e); !allowed.empty())
      problems.add(fmt::format("operator.{}.does", k + 1),
                   fmt::format("found \"{}\", allowed: {}", describe(event), allowed));
  }
}

}  // namespace

void read_events(TomlTable& document, Experiment& experiment) {
  read_perturbations(document, experiment);
  read_actions(document, experiment);
}

void check_events(const Experiment& experiment, Problems& problems) {
  check_perturbations(experiment, problems);
  check_actions(experiment, problems);
}

}  // namespace skein::app
