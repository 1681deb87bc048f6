#include <fmt/format.h>

#include <atomic>
#include <filesystem>

#include "app/cli/commands.h"
#include "app/experiment/known_robots.h"
#include "app/guard/safety_net.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/tools/robot_test.h"

namespace skein::app {
namespace {

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

/// What of it the file of robots keeps.
FoundRobot to_keep(const Experiment& experiment, std::size_t robot, const RobotTestResult& result) {
  FoundRobot found{experiment.robots[robot], robot_name(experiment, robot), {}};
  const auto keep = [&](const char* key, std::string value) { found.values.emplace_back(key, std::move(value)); };
  if (result.tag >= 0) keep("tag", std::to_string(result.tag));
  if (!result.status.version.empty()) keep("version", fmt::format("\"{}\"", result.status.version));
  if (result.wheel_diameter) keep("wheel_diameter", fmt::format("{:.5f}", *result.wheel_diameter));
  if (result.watchdog) keep("watchdog", fmt::format("{:.2f}", *result.watchdog));
  if (result.track) keep("track", fmt::format("{:.5f}", *result.track));
  return found;
}

}  // namespace

int test_robots(const RobotsRequest& request) {
  const auto named = named_robots(request.words, request.file);
  if (!named) return wrong_input;
  Experiment experiment = named->experiment.value_or(Experiment{});
  if (!named->experiment) experiment.robots = named->robots;
  if (!request.camera.empty()) {
    experiment.camera.also.clear();
    experiment.camera.source = request.camera;
    experiment.camera.calibration = std::filesystem::absolute(request.calibration).string();
  }
  experiment.failure.link_lost = FailureSpec::LinkLost::all_stop;
  const auto addresses = real_robots(experiment);
  if (!addresses) {
    complain(addresses.error());
    return wrong_input;
  }
  tl::expected<SafetyNet, std::string> net;
  if (!addresses->empty()) net = SafetyNet::spread({experiment.name, *addresses});
  if (!net) complain(fmt::format("{}: if this program is killed, nothing stops the robots", net.error()));

  SessionClock clock(anything_real(experiment));
  SessionOptions options;
  options.every_tag = true;
  auto plant = Plant::open(experiment, clock, options);
  if (!plant) {
    if (net) net->done(std::vector<StopResult>{});  // those that were reached have been stopped
    complain(plant.error());
    return device_failed;
  }
  std::atomic<bool> stop_asked{false};
  if (net)
    net->on_stop([&] { stop_asked = true, (*plant)->stop(); },
                 [&] { return stop_results(experiment, (*plant)->robots()); });
  RobotTest test(**plant, clock, experiment, [&] { return !interrupted() && !stop_asked; });
  std::vector<FoundRobot> found;
  bool good = true;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    if (!experiment.robots[i].has_link()) continue;
    auto result = test.test(i);
    if (!result) {
      complain(fmt::format("{}: {}", robot_name(experiment, i), result.error()));
      good = false;
      break;
    }
    print(*result, experiment, i);
    good = good && result->faults.empty();
    found.push_back(to_keep(experiment, i, *result));
  }
  if (net) net->on_stop({}, {});
  (*plant)->close();
  const std::vector<RobotStatus> robots = (*plant)->robots();
  if (net) net->done(stop_results(experiment, robots));
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (robots[i].stop_acknowledged) continue;
    complain(robot_name(experiment, i) + " has NOT acknowledged its stop and may still be driving");
    good = false;
  }
  const int saved = request.save ? save_found(known_robots_file(request.file), found) : done;
  return saved != done ? saved : good ? done : device_failed;
}

}  // namespace skein::app
