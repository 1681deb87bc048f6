#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/tools/robot_ping.h"

namespace skein::app {
namespace {

void print(const RobotPing::Robot& robot, double seconds) {
  const comms::LinkStatus& status = robot.status;
  print_out(
      fmt::format("{}{}\n", shown(robot.name), robot.adapter.empty() ? "" : fmt::format(" over {}", robot.adapter)));
  print_out(fmt::format("  questions answered: {} in {:g} s\n", status.exchanges, seconds));
  print_out(fmt::format("  round_trip_ms: {:.1f} median, {:.1f} p99, {:.1f} p99.9\n",
                        1e3 * robot.times.quantile_since_start(0.5), 1e3 * robot.times.quantile_since_start(0.99),
                        1e3 * robot.times.quantile_since_start(0.999)));
  print_out(fmt::format("  lost: {}, connections lost: {}, wrong speeds: {}\n", status.timeouts, status.reconnects,
                        status.wrong_speeds));
  for (const std::string& line : histogram(robot.times)) print_out(fmt::format("  {}\n", line));
}

}  // namespace

int ping_robots(const RobotsRequest& request) {
  const auto named = named_robots(request.words, request.file);
  if (!named) return wrong_input;
  if (request.save && !named->experiment) {
    complain("--save writes [links] to an experiment file: name one, and nothing else");
    return wrong_input;
  }
  if (request.save &&
      !can_save_keys(request.words.front(), {{"links.blind_distance", "0.05"}, {"links.reply_timeout", "0.5"}}))
    return wrong_input;
  Experiment experiment = named->experiment.value_or(Experiment{});
  if (!named->experiment) experiment.robots = named->robots;
  const auto ping = ping_robots(experiment, {.seconds = 60.0 * request.minutes,
                                             .keep_on = [] { return !interrupted(); },
                                             .warn = [](const std::string& sentence) { complain(sentence); }});
  if (!ping) {
    complain(ping.error());
    return device_failed;
  }
  bool good = true;
  double worst = 0.0;
  std::map<std::string, comms::RoundTrips> adapters;
  for (const RobotPing::Robot& robot : ping->robots) {
    print(robot, ping->seconds);
    worst = std::max(worst, robot.times.quantile_since_start(0.999));
    if (!robot.adapter.empty()) adapters[robot.adapter].add(robot.times);
    if (!robot.stop_acknowledged) complain(robot.name + " has NOT acknowledged its stop");
    good = good && robot.stop_acknowledged && robot.answered();
  }
  for (const auto& [name, times] : adapters) {
    print_out(fmt::format("all over {}: {:.1f} ms median, {:.1f} p99.9\n", name, 1e3 * times.quantile_since_start(0.5),
                          1e3 * times.quantile_since_start(0.999)));
    for (const std::string& line : histogram(times)) print_out(fmt::format("  {}\n", line));
  }
  const LinksSpec links = proposed_links(worst, experiment.controller.v_max, experiment.period());
  print_out(fmt::format("\n[links]\nblind_distance = {:g}\nreply_timeout = {:g}\n", links.blind_distance,
                        links.reply_timeout));
  const int saved =
      request.save && good
          ? save_keys(request.words.front(), {{"links.blind_distance", fmt::format("{:g}", links.blind_distance)},
                                              {"links.reply_timeout", fmt::format("{:g}", links.reply_timeout)}})
          : done;
  return saved != done ? saved : good ? done : device_failed;
}

}  // namespace skein::app
