#include <fmt/format.h>

#include "app/command_line.h"
#include "app/commands.h"
#include "comms/bluez.h"

namespace skein::app {
namespace {

bool not_interrupted() {
  return !interrupted();
}

/// One robot, as an experiment file or a file of robots has it.
std::string as_toml(const comms::BluetoothRobot& robot) {
  const char* model = robot.model() == core::MotorModel::epuck2 ? "epuck2" : "epuck1";
  return fmt::format("[[robot]]  # {}{}\nlink = \"{}\"\nadapter = \"{}\"\nmodel = \"{}\"\n", robot.name,
                     robot.paired ? ", paired" : ", not paired", comms::to_text(robot.link()), robot.adapter, model);
}

}  // namespace

int scan_robots(const std::string& adapter, double seconds) {
  const auto robots = comms::scan_robots({adapter, seconds, not_interrupted});
  if (!robots) {
    fmt::print(stderr, "skein: {}\n", robots.error());
    return device_failed;
  }
  for (const comms::BluetoothRobot& robot : *robots) fmt::print("{}\n", as_toml(robot));
  if (robots->empty()) {
    fmt::print(stderr,
               "skein: no robot was heard. Is it switched on and in range? An e-puck2 is heard only when its "
               "button is held while it is switched on\n");
    return device_failed;
  }
  return done;
}

int pair_robots(const std::vector<std::string>& robots, const std::string& adapter) {
  int status = done;
  for (const std::string& name : robots) {
    const auto robot = comms::pair_robot({.robot = name, .adapter = adapter, .keep_on = not_interrupted});
    if (robot) {
      fmt::print("{}\n", as_toml(*robot));
      continue;
    }
    fmt::print(stderr, "skein: {}: {}\n", name, robot.error());
    status = device_failed;
  }
  return status;
}

}  // namespace skein::app
