#include <fmt/format.h>

#include <filesystem>

#include "app/cli/commands.h"
#include "app/experiment/experiment_robots.h"
#include "app/experiment/file_change.h"
#include "app/experiment/known_robots.h"
#include "app/experiment/text_file.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "comms/bluez.h"

namespace skein::app {
namespace {

bool not_interrupted() {
  return !interrupted();
}

KnownRobot known(const comms::BluetoothRobot& robot) {
  KnownRobot known;
  known.spec.name = robot.name;
  known.spec.tag = -1;
  known.spec.link = RobotSpec::Link::device;
  known.spec.address = comms::to_text(robot.link());
  known.spec.adapter = robot.adapter;
  become(known.spec, *core::find_robot_type(core::word(robot.model())));  // types have the names of their motors
  return known;
}

void print(const comms::BluetoothRobot& robot) {
  fmt::print("# {}, {}\n{}\n", robot.name, robot.paired ? "paired" : "not paired", as_toml(known(robot)));
}

/// Adds the robots to the file of robots, and says so.
int save(const std::string& file, const std::vector<comms::BluetoothRobot>& found) {
  const std::string path = known_robots_file(file);
  auto change = FileChange::begin(path);
  if (!change) {
    complain(change.error());
    return wrong_input;
  }
  std::string text;
  std::vector<KnownRobot> there, more;
  if (std::filesystem::exists(path)) {
    const auto read = read_text(path);
    auto robots = load_known_robots(path);
    if (!read || !robots) {
      print_error(messages(robots ? read.error() : robots.error()) + "\n");
      return wrong_input;
    }
    text = *read;
    there = std::move(*robots);
  }
  for (const comms::BluetoothRobot& robot : found) more.push_back(known(robot));
  const Added added = with_robots(text, there, more);
  if (added.robots > 0)
    if (const auto saved = change->save(added.text); !saved) {
      complain(saved.error());
      return wrong_input;
    }
  fmt::print("# {}: {} robots added, {} already present\n", path, added.robots, found.size() - added.robots);
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
    print_error(
        "skein: no robot found. Is it switched on and in range? An e-puck2 is discoverable only when its button is "
        "held while it is switched on\n");
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
    print_error(fmt::format("skein: {}: {}\n", name, robot.error()));
    status = device_failed;
  }
  const int saved = request.save && !paired.empty() ? save(request.file, paired) : done;
  return saved != done ? saved : status;
}

}  // namespace skein::app
