#include <fmt/format.h>

#include "app/cli/commands.h"
#include "app/experiment/robots_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/tools/robot_setup.h"
#include "comms/bluez.h"

namespace skein::app {
namespace {

bool not_interrupted() {
  return !interrupted();
}

void print(const comms::BluetoothRobot& robot) {
  print_out(fmt::format("# {}, {}\n{}\n", shown(robot.name), robot.paired ? "paired" : "not paired",
                        shown_lines(as_toml(known_robot(robot)))));
}

/// Adds the robots to the file of robots, and says so.
int save(const std::string& file, const std::vector<comms::BluetoothRobot>& found) {
  const std::string path = known_robots_file(file);
  std::vector<KnownRobot> more;
  more.reserve(found.size());
  for (const comms::BluetoothRobot& robot : found) more.push_back(known_robot(robot));
  const auto added = add_to_robots_file(path, more);
  if (!added) {
    print_error(added.error() + "\n");
    return wrong_input;
  }
  print_out(fmt::format("# {}: {} robots added, {} already present\n", shown(path), *added, found.size() - *added));
  return done;
}

/// Refuses what cannot be an adapter before anybody looks for it.
bool possible(const std::string& adapter) {
  const auto checked = comms::check_adapter(adapter);
  if (!checked) complain(checked.error());
  return checked.has_value();
}

}  // namespace

int scan_robots(const RobotsRequest& request) {
  if (!possible(request.adapter)) return wrong_input;
  const auto robots = comms::scan_robots({request.adapter, request.seconds, not_interrupted});
  if (!robots) {
    complain(robots.error());
    return device_failed;
  }
  for (const comms::BluetoothRobot& robot : *robots) print(robot);
  if (robots->empty()) {
    complain(
        "no robot found. Is it switched on and in range? An e-puck2 is discoverable only when its button is "
        "held while it is switched on");
    return device_failed;
  }
  return request.save ? save(request.file, *robots) : done;
}

int pair_robots(const RobotsRequest& request) {
  if (!possible(request.adapter)) return wrong_input;
  int status = done;
  std::vector<comms::BluetoothRobot> paired;
  for (const std::string& name : request.words) {
    const auto robot = comms::pair_robot({.robot = name, .adapter = request.adapter, .keep_on = not_interrupted});
    if (robot) {
      print(*robot);
      paired.push_back(*robot);
      continue;
    }
    complain(fmt::format("{}: {}", name, robot.error()));
    status = device_failed;
  }
  const int saved = request.save && !paired.empty() ? save(request.file, paired) : done;
  return saved != done ? saved : status;
}

}  // namespace skein::app
