#include "app/experiment/experiment_robots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/experiment_trajectory.h"
#include "app/experiment/longest.h"
#include "comms/link_address.h"
#include "core/geometry/pose.h"
#include "vision/tags/tag_family.h"

namespace skein::app {
namespace {

/// The types that a robot with a link can have.
std::string linked_type_names() {
  std::string names;
  for (const core::RobotType& type : core::robot_types)
    if (type.motor != core::MotorModel::ideal) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", type.name);
  return names;
}

void read_link(TomlTable& t, RobotSpec& robot) {
  const toml::node* const found = t.node("link");
  if (!found) return;
  const std::string_view text = found->value_exact<std::string_view>().value_or("");
  const auto parsed = comms::parse_link_address(text);
  if (text == "sim")
    robot.link = RobotSpec::Link::sim;
  else if (text == "loopback")
    robot.link = RobotSpec::Link::loopback;
  else if (parsed)
    robot.link = RobotSpec::Link::device;
  else
    t.refuse("link", *found,
             R"("sim", "loopback", "rfcomm:ADDRESS/CHANNEL", "serial:/dev/...", "tcp:HOST:PORT" or "udp:HOST:PORT")" +
                 (comms::is_link_address(text) ? fmt::format(" ({})", parsed.error()) : ""));
  robot.address = parsed ? std::string(text) : "";
}

/// Where a simulated robot stands at first: [x, y, theta].
void read_start(TomlTable& t, RobotSpec& robot, const Experiment& e) {
  const toml::node* const found = t.node("start");
  if (!found) return;
  const double x_most = 0.5 * e.arena_width, y_most = 0.5 * e.arena_height;
  const auto pose = numbers_of<3>(*found);
  if (pose && std::abs((*pose)[0]) <= x_most && std::abs((*pose)[1]) <= y_most && std::abs((*pose)[2]) <= full_turn)
    robot.start = {(*pose)[0], (*pose)[1],
                   std::abs((*pose)[2]) <= core::pi ? (*pose)[2] : core::wrap_angle((*pose)[2])};
  else
    t.refuse("start", *found,
             fmt::format("[x, y, theta] inside the arena: x from -{0:.6g} to {0:.6g} m, y from -{1:.6g} to {1:.6g} m, "
                         "theta from -{2} to {2} rad",
                         x_most, y_most, full_turn));
}

void read_drive(TomlTable& t, DriveKeys& drive) {
  t.number("wheel_diameter", drive.wheel_diameter, between(0.01, 0.2, "m"));
  t.number("wheel_ratio", drive.wheel_ratio, between(0.8, 1.25));
  t.number("track", drive.track, between(0.01, 0.5, "m"));
}

/// When a simulated robot ceases to obey, and how it drives then.
void read_runaway(TomlTable& t, std::optional<RobotSpec::Truth::Runaway>& runaway) {
  const toml::node* const found = t.node("runaway");
  if (!found) return;
  const Range at = between(0.0, longest_run, "s"), v = between(-1.0, 1.0, "m/s"), omega = between(-10.0, 10.0, "rad/s");
  const auto alone = numbers_of<1>(*found);
  const auto with_twist = numbers_of<3>(*found);
  if (alone && at.holds((*alone)[0]))
    runaway = {(*alone)[0], {}};
  else if (with_twist && at.holds((*with_twist)[0]) && v.holds((*with_twist)[1]) && omega.holds((*with_twist)[2]))
    runaway = {(*with_twist)[0], core::Twist{(*with_twist)[1], (*with_twist)[2]}};
  else
    t.refuse("runaway", *found,
             fmt::format("[t] or [t, v, omega]: t {}, v {}, omega {}", at.text(), v.text(), omega.text()));
}

/// What a simulated robot is really like.
void read_truth(TomlTable& t, RobotKeys& robot) {
  TomlTable table = t.table("truth");
  if (!t.has("truth")) return;
  RobotKeys::Truth& truth = robot.truth.emplace(RobotKeys::Truth{});
  read_drive(table, truth.drive);
  table.number("actuation_delay", truth.actuation_delay, between(0.0, 0.5, "s"));
  read_runaway(table, truth.runaway);
  table.finish();
}

}  // namespace

void read_robot(TomlTable& t, RobotKeys& robot, Problems& problems) {
  read_link(t, robot.spec);
  t.text("adapter", robot.spec.adapter);
  if (const auto known = comms::check_adapter(robot.spec.adapter); !known && t.has("adapter"))
    problems.add(t.full("adapter"), known.error());
  t.number("radius", robot.radius, between(0.01, 0.5, "m"));
  read_drive(t, robot.drive);
  t.number("actuation_delay", robot.spec.actuation_delay, between(0.0, 1.0, "s"));
  t.number("watchdog", robot.spec.watchdog, between(0.0, 60.0, "s"));
  t.number("v_max", robot.spec.v_max, above(0.0, 10.0, "m/s"));
  t.number("omega_max", robot.spec.omega_max, above(0.0, 100.0, "rad/s"));
  t.number("c_x", robot.spec.c_x, above(0.0, 1e4, "1/m"));
  t.number("c_theta", robot.spec.c_theta, above(0.0, 1e4, "1/rad"));
  t.number("k_x", robot.spec.k_x, above(0.0, 100.0, "m/s"));
  t.number("k_theta", robot.spec.k_theta, above(0.0, 100.0, "rad/s"));
  t.number("alpha", robot.spec.alpha, above(0.0, 100.0, "m"));
  t.number("beta", robot.spec.beta, above(0.0, 100.0, "m"));
  t.integer("p", robot.spec.p, 1, 50);
  t.number("K_a", robot.spec.K_a, between(0.0, 1e3, "1/s"));
  t.number("K_o", robot.spec.K_o, between(0.0, 1e3, "m^2/s"));
  if (const toml::node* const model = t.node("model")) {
    robot.model_key = t.full("model");
    if (const auto* const type = core::find_robot_type(model->value_exact<std::string_view>().value_or("")))
      robot.model = type;
    else
      t.refuse("model", *model, core::robot_type_names());
  }
}

constexpr const core::RobotType& epuck2 = *core::find_robot_type("epuck2");
constexpr const core::RobotType& ideal = *core::find_robot_type("ideal");

void become(RobotSpec& robot, const core::RobotType& type) {
  robot.type = &type;
  robot.motor = type.motor;
  robot.radius = type.radius;
  robot.drive = type.wheels;
  robot.watchdog = type.watchdog;
}

const core::RobotType& type_spoken(const comms::LinkAddress& address) {
  for (const core::RobotType& type : core::robot_types)
    if (!type.protocol.empty() && type.protocol == comms::language(address)) return type;
  return epuck2;
}

RobotSpec finished(const RobotKeys& keys, Problems& problems) {
  RobotSpec robot = keys.spec;
  const bool linked = robot.has_link();
  const auto address = comms::parse_link_address(robot.address);
  const core::RobotType& type = keys.model ? *keys.model : address ? type_spoken(*address) : linked ? epuck2 : ideal;
  // A robot takes whole speeds only; a simulation can do better.
  if (linked && type.motor == core::MotorModel::ideal)
    problems.add(keys.model_key, fmt::format("found \"{}\", allowed: {}; only a robot of link \"sim\" can be ideal",
                                             type.name, linked_type_names()));
  if (robot.is_real() && address) {
    const auto spoken = comms::spoken_by(*address, type.protocol);
    if (!spoken)
      problems.add(keys.model_key, spoken.error());
    else if (*spoken != *address)
      robot.address = comms::to_text(*spoken);  // it alone says how the robot is reached
  }
  const std::optional<double> watchdog = robot.watchdog;
  become(robot, type);
  if (watchdog) robot.watchdog = watchdog;
  robot.radius = keys.radius.value_or(type.radius);
  robot.drive = keys.drive.over(type.wheels);
  if (keys.truth)
    robot.truth.emplace(
        RobotSpec::Truth{keys.truth->drive.over(robot.drive), keys.truth->actuation_delay, keys.truth->runaway});
  return robot;
}

void read_name_and_tag(TomlTable& t, RobotSpec& robot) {
  constexpr std::size_t longest_robot_name = 40;
  t.line("name", robot.name, longest_robot_name);
  t.integer("tag", robot.tag, 0, vision::largest_tag);
}

void read_robots(TomlTable& document, Experiment& e, Problems& problems) {
  RobotKeys defaults;
  TomlTable defaults_table = document.table("robot_defaults");
  read_robot(defaults_table, defaults, problems);
  defaults_table.finish();

  std::vector<TomlTable> tables = document.tables("robot");
  if (document.has("robot") && document.sound("robot") && (tables.empty() || tables.size() > most_robots))
    problems.add("robot", fmt::format("found {} robots, allowed: 1 to {}", tables.size(), most_robots));
  if (tables.empty()) tables.assign(4, TomlTable(nullptr, "robot", problems));  // the paper's four
  tables.erase(tables.begin() + static_cast<std::ptrdiff_t>(std::min(tables.size(), most_robots)), tables.end());
  for (TomlTable& t : tables) {
    RobotKeys robot = defaults;
    robot.spec.tag = static_cast<int>(e.robots.size()) + 1;
    read_name_and_tag(t, robot.spec);
    read_start(t, robot.spec, e);
    read_robot(t, robot, problems);
    read_truth(t, robot);
    if (robot.truth && !robot.spec.simulated())
      problems.add(t.full("truth"),
                   "found for a real robot, allowed: for simulated ones (link \"sim\" or \"loopback\")");
    if (TomlTable trajectory = t.table("trajectory"); t.has("trajectory"))
      read_trajectory(trajectory, robot.spec.trajectory.emplace());
    t.finish();
    e.robots.push_back(finished(robot, problems));
  }
}

}  // namespace skein::app
