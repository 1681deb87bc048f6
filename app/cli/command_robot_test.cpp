#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/cli/commands.h"
#include "app/experiment/known_robots.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_edit.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/session/safety_net.h"
#include "app/tools/robot_test.h"

namespace skein::app {
namespace {

void complain(const std::string& text) {
  fmt::print(stderr, "skein: {}\n", text);
}

void print(const RobotTestResult& result, const Experiment& experiment, std::size_t robot) {
  const auto said = [](const std::string& text) { return text.empty() ? "not said" : text; };
  const std::string& address = experiment.robots[robot].address;
  fmt::print("{}: {}\n", robot_name(experiment, robot), address.empty() ? "emulated" : address);
  fmt::print("version: {}\nbattery: {}\nleft_steps: {}\nright_steps: {}\n", said(result.status.version),
             result.status.battery_text, result.left_steps, result.right_steps);
  if (result.tag >= 0) fmt::print("tag: {}\n", result.tag);
  if (result.wheel_diameter) fmt::print("wheel_diameter: {:.5f}\n", *result.wheel_diameter);
  if (result.track) fmt::print("track: {:.5f}\n", *result.track);
  if (result.watchdog)
    fmt::print("watchdog: {}\n", *result.watchdog == 0.0
                                     ? "none: it drives on when nothing is sent to it"
                                     : fmt::format("{:.2f} s: it stopped by itself", *result.watchdog));
  fmt::print("faults: {}\n\n", result.faults.size());
  std::fflush(stdout);
  for (const std::string& fault : result.faults) complain(robot_name(experiment, robot) + ": " + fault);
  for (const std::string& note : result.notes) complain(robot_name(experiment, robot) + ": " + note);
}

/// Puts what was found into the file of robots.
int save(const std::string& path, const Experiment& experiment,
         const std::vector<std::pair<std::size_t, RobotTestResult>>& results) {
  const auto known = load_known_robots(path);
  const auto text = read_text(path);
  if (!known || !text) {
    for (const Problem& problem : known ? text.error() : known.error()) fmt::print(stderr, "{}\n", problem.message());
    return wrong_input;
  }
  std::string changed = *text;
  for (const auto& [robot, result] : results) {
    const RobotSpec& spec = experiment.robots[robot];
    const auto found = std::find_if(known->begin(), known->end(), [&](const KnownRobot& k) { return is(k, spec); });
    if (found == known->end()) {
      complain(fmt::format("{} is not in {}: nothing of it was saved", robot_name(experiment, robot), path));
      continue;
    }
    const auto set = [&, n = found - known->begin() + 1](const char* key, const std::string& value) {
      auto with = with_toml_value(changed, fmt::format("robot.{}.{}", n, key), value);
      if (with) changed = std::move(*with);
      if (!with) complain(fmt::format("{}: {}", path, with.error()));
    };
    if (result.tag >= 0) set("tag", std::to_string(result.tag));
    if (!result.status.version.empty()) set("version", fmt::format("\"{}\"", result.status.version));
    if (result.wheel_diameter) set("wheel_diameter", fmt::format("{:.5f}", *result.wheel_diameter));
    if (result.watchdog) set("watchdog", fmt::format("{:.2f}", *result.watchdog));
    if (result.track) set("track", fmt::format("{:.5f}", *result.track));
  }
  if (changed == *text) return done;
  if (const auto saved = save_known_robots(path, changed); !saved) {
    complain(saved.error());
    return wrong_input;
  }
  fmt::print("# saved in {}\n", path);
  return done;
}

}  // namespace

int test_robots(const RobotsRequest& request) {
  const auto named = named_robots(request.words, request.file);
  if (!named) return wrong_input;
  Experiment experiment = named->experiment.value_or(Experiment{});
  if (!named->experiment) experiment.robots = named->robots;
  if (!request.camera.empty()) {
    experiment.camera.source = request.camera;
    experiment.camera.calibration = std::filesystem::absolute(request.calibration).string();
  }
  experiment.failure.link_lost = FailureSpec::LinkLost::all_stop;
  auto net = SafetyNet::spread(experiment);
  if (!net) complain(fmt::format("{}: should this program be killed, nothing stops the robots", net.error()));

  SessionClock clock(anything_real(experiment));
  SessionOptions options;
  options.every_tag = true;
  auto plant = Plant::open(experiment, clock, options);
  if (!plant) {
    if (net) net->done({});  // those that were reached have been stopped
    complain(plant.error());
    return device_failed;
  }
  RobotTest test(**plant, clock, experiment, [] { return !interrupted(); });
  std::vector<std::pair<std::size_t, RobotTestResult>> results;
  bool good = true;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    if (experiment.robots[i].link == RobotSpec::Link::sim) continue;
    auto result = test.test(i);
    if (!result) {
      complain(fmt::format("{}: {}", robot_name(experiment, i), result.error()));
      good = false;
      break;
    }
    print(*result, experiment, i);
    good = good && result->faults.empty();
    results.emplace_back(i, std::move(*result));
  }
  (*plant)->close();
  const std::vector<RobotStatus> robots = (*plant)->robots();
  if (net) net->done(robots);
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (robots[i].stop_acknowledged) continue;
    complain(robot_name(experiment, i) + " has NOT acknowledged its stop and may still be driving");
    good = false;
  }
  const int saved = request.save ? save(known_robots_file(request.file), experiment, results) : done;
  return saved != done ? saved : good ? done : device_failed;
}

}  // namespace skein::app
