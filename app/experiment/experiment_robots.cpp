#include "app/experiment/experiment_robots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/experiment_trajectory.h"
#include "comms/link_address.h"
#include "core/geometry/pose.h"

namespace skein::app {
namespace {

constexpr std::size_t most_robots = 64;

void read_link(TomlTable& t, RobotSpec& robot) {
  const toml::node* const found = t.node("link");
  if (!found) return;
  const std::string_view text = found->value_exact<std::string_view>().value_or("");
  const bool address = text.starts_with("rfcomm:") || text.starts_with("serial:") || text.starts_with("tcp:");
  const auto parsed = comms::parse_link_address(text);
  if (text == "sim")
    robot.link = RobotSpec::Link::sim;
  else if (text == "loopback")
    robot.link = RobotSpec::Link::loopback;
  else if (parsed)
    robot.link = RobotSpec::Link::device;
  else
    t.refuse("link", *found,
             R"("sim", "loopback", "rfcomm:ADDRESS/CHANNEL", "serial:/dev/..." or "tcp:HOST:PORT")" +
                 (address ? fmt::format(" ({})", parsed.error()) : ""));
  robot.address = parsed ? std::string(text) : "";
}

/// Where a simulated robot stands at first: [x, y, theta].
void read_start(TomlTable& t, RobotSpec& robot, const Experiment& e) {
  const toml::node* const found = t.node("start");
  if (!found) return;
  const toml::array* const pose = found->as_array();
  const auto number = [&](std::size_t k, double most) {
    const auto value = pose && pose->size() == 3 && (*pose)[k].is_number() ? (*pose)[k].value<double>() : std::nullopt;
    return value && std::abs(*value) <= most ? value : std::nullopt;
  };
  const double x_most = 0.5 * e.arena_width, y_most = 0.5 * e.arena_height;
  const auto x = number(0, x_most), y = number(1, y_most), theta = number(2, core::pi);
  if (x && y && theta)
    robot.start = {*x, *y, *theta};
  else
    t.refuse("start", *found,
             fmt::format("[x, y, theta] inside the arena: x from -{0:.6g} to {0:.6g} m, y from -{1:.6g} to {1:.6g} m, "
                         "theta from -pi to pi",
                         x_most, y_most));
}

}  // namespace

void read_robot(TomlTable& t, RobotKeys& robot, Problems& problems) {
  using Model = core::MotorModel;
  read_link(t, robot.spec);
  t.text("adapter", robot.spec.adapter);
  if (const auto known = comms::check_adapter(robot.spec.adapter); !known && t.has("adapter"))
    problems.add(t.full("adapter"), known.error());
  t.number("wheel_diameter", robot.spec.drive.wheel_diameter, between(0.01, 0.2, "m"));
  t.number("watchdog", robot.spec.watchdog, between(0.0, 60.0, "s"));
  t.number("track", robot.spec.drive.track, between(0.01, 0.5, "m"));
  Model model = Model::ideal;
  t.choice("model", model);
  if (t.has("model")) robot.model = model, robot.model_key = t.full("model");
}

RobotSpec finished(const RobotKeys& keys, Problems& problems) {
  RobotSpec robot = keys.spec;
  const bool steps = robot.link != RobotSpec::Link::sim;  // an e-puck's firmware is asked for whole steps
  robot.motor = keys.model.value_or(steps ? core::MotorModel::epuck2 : core::MotorModel::ideal);
  if (steps && robot.motor == core::MotorModel::ideal)
    problems.add(keys.model_key,
                 R"(found "ideal", allowed: "epuck1", "epuck2"; only a robot of link "sim" can be ideal)");
  robot.drive.max_step_rate = core::max_step_rate(robot.motor);
  return robot;
}

void read_name_and_tag(TomlTable& t, RobotSpec& robot) {
  constexpr std::size_t longest_name = 40;
  t.line("name", robot.name, longest_name);
  t.integer("tag", robot.tag, 0, 586);  // the ids of the family 36h11
}

void read_robots(TomlTable& document, Experiment& e, Problems& problems) {
  RobotKeys defaults;
  TomlTable defaults_table = document.table("robot_defaults");
  read_robot(defaults_table, defaults, problems);
  defaults_table.finish();

  std::vector<TomlTable> tables = document.tables("robot");
  if (document.has("robot") && (tables.empty() || tables.size() > most_robots))
    problems.add("robot", fmt::format("found {} robots, allowed: 1 to {}", tables.size(), most_robots));
  if (tables.empty()) tables.assign(4, TomlTable(nullptr, "robot", problems));  // the paper's four
  tables.erase(tables.begin() + static_cast<std::ptrdiff_t>(std::min(tables.size(), most_robots)), tables.end());
  for (TomlTable& t : tables) {
    RobotKeys robot = defaults;
    robot.spec.tag = static_cast<int>(e.robots.size()) + 1;
    read_name_and_tag(t, robot.spec);
    read_start(t, robot.spec, e);
    read_robot(t, robot, problems);
    if (TomlTable trajectory = t.table("trajectory"); t.has("trajectory"))
      read_trajectory(trajectory, robot.spec.trajectory.emplace());
    t.finish();
    e.robots.push_back(finished(robot, problems));
  }
}

}  // namespace skein::app
