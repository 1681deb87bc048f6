#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "app/cli/commands.h"
#include "app/experiment/known_robots.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/session/experiment_cameras.h"
#include "app/tools/driven_plant.h"
#include "app/tools/robot_test.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

void print(const RobotTestResult& result, const Experiment& experiment, std::size_t robot) {
  const auto said = [](const std::string& text) { return text.empty() ? "not said" : text; };
  const std::string& address = experiment.robots[robot].address;
  print_out(
      fmt::format("{}: {}\n", shown(robot_name(experiment, robot)), address.empty() ? "emulated" : shown(address)));
  print_out(fmt::format("version: {}\nbattery: {}\nleft_steps: {}\nright_steps: {}\n",
                        shown(said(result.status.version)), shown(result.status.battery_text), result.left_steps,
                        result.right_steps));
  if (result.tag >= 0) print_out(fmt::format("tag: {}\n", result.tag));
  if (result.wheel_diameter) print_out(fmt::format("wheel_diameter: {:.5f}\n", *result.wheel_diameter));
  if (result.track) print_out(fmt::format("track: {:.5f}\n", *result.track));
  if (result.watchdog)
    print_out(fmt::format("watchdog: {}\n", *result.watchdog == 0.0
                                                ? "none: it drives on when nothing is sent to it"
                                                : fmt::format("{:.2f} s: it stopped by itself", *result.watchdog)));
  print_out(fmt::format("faults: {}\n\n", result.faults.size()));
  for (const std::string& fault : result.faults) complain(robot_name(experiment, robot) + ": " + fault);
  for (const std::string& note : result.notes) complain(robot_name(experiment, robot) + ": " + note);
}

}  // namespace

int test_robots(const RobotsRequest& request) {
  const auto named = named_robots(request.words, request.file);
  if (!named) return wrong_input;
  Experiment experiment = named->experiment.value_or(Experiment{});
  if (!named->experiment) experiment.robots = named->robots;
  if (request.reply_timeout) experiment.links.reply_timeout = *request.reply_timeout;
  if (!request.camera.empty()) {
    if (!vision::is_camera(request.camera)) {
      complain(fmt::format("--camera {}: is not a camera; allowed: {}", request.camera, vision::camera_forms()));
      return wrong_input;
    }
    experiment.camera.also.clear();
    experiment.camera.source = request.camera;
    experiment.camera.calibration = std::filesystem::absolute(request.calibration).string();
  }
  if (!can_read_calibrations(experiment)) return wrong_input;
  if (request.save)  // nothing yet: what prevents it is to be known before a robot drives
    if (const int possible = save_found(known_robots_file(request.file), {}); possible != done) return possible;
  SessionOptions options;
  options.every_tag = true;
  const auto driven = DrivenPlant::open(std::move(experiment), options, complain);
  if (!driven) {
    complain(driven.error());
    return device_failed;
  }
  const Experiment& believed = (*driven)->experiment();
  RobotTest test((*driven)->plant(), (*driven)->clock(), believed, [&] { return (*driven)->keep_on(); });
  std::vector<FoundRobot> found;
  bool good = true;
  for (std::size_t i = 0; i < believed.robots.size(); ++i) {
    if (!believed.robots[i].has_link()) continue;
    auto result = test.test(i);
    if (!result) {
      complain(fmt::format("{}: {}", robot_name(believed, i), result.error()));
      good = false;
      break;
    }
    print(*result, believed, i);
    good = good && result->faults.empty();
    found.push_back({believed.robots[i], robot_name(believed, i), values_to_keep(*result)});
  }
  good = (*driven)->close() && good;
  const int saved = request.save ? save_found(known_robots_file(request.file), found) : done;
  return saved != done ? saved : good ? done : device_failed;
}

}  // namespace skein::app
