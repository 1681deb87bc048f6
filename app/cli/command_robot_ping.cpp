#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <map>

#include "app/cli/commands.h"
#include "app/experiment/file_change.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_edit.h"
#include "app/guard/safety_net.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/tools/robot_ping.h"

namespace skein::app {
namespace {

void print(const RobotPing::Robot& robot, double seconds) {
  const comms::LinkStatus& status = robot.status;
  fmt::print("{}{}\n", robot.name, robot.adapter.empty() ? "" : fmt::format(" over {}", robot.adapter));
  fmt::print("  questions answered: {} in {:g} s\n", status.exchanges, seconds);
  fmt::print("  round_trip_ms: {:.1f} median, {:.1f} p99, {:.1f} p99.9\n", 1e3 * robot.times.quantile_since_start(0.5),
             1e3 * robot.times.quantile_since_start(0.99), 1e3 * robot.times.quantile_since_start(0.999));
  fmt::print("  lost: {}, connections lost: {}, wrong speeds: {}\n", status.timeouts, status.reconnects,
             status.wrong_speeds);
  for (const std::string& line : histogram(robot.times)) fmt::print("  {}\n", line);
}

int save(const std::string& file, const LinksSpec& links) {
  auto change = FileChange::begin(file);
  if (!change) {
    complain(change.error());
    return wrong_input;
  }
  auto text = read_text(file);
  if (!text) {
    print_error(messages(text.error()) + "\n");
    return wrong_input;
  }
  for (const auto& [key, value] :
       {std::pair{"links.blind_distance", links.blind_distance}, {"links.reply_timeout", links.reply_timeout}}) {
    auto with = with_toml_value(*text, key, fmt::format("{:g}", value));
    if (!with) {
      complain(fmt::format("{}: {}", file, with.error()));
      return wrong_input;
    }
    *text = std::move(*with);
  }
  if (const auto saved = change->save(*text); !saved) {
    complain(saved.error());
    return wrong_input;
  }
  fmt::print("# saved in {}\n", file);
  return done;
}

}  // namespace

int ping_robots(const RobotsRequest& request) {
  const auto named = named_robots(request.words, request.file);
  if (!named) return wrong_input;
  if (request.save && !named->experiment) {
    complain("--save writes [links] to an experiment file: name one, and nothing else");
    return wrong_input;
  }
  Experiment experiment = named->experiment.value_or(Experiment{});
  if (!named->experiment) experiment.robots = named->robots;
  const auto addresses = real_robots(experiment);
  if (!addresses) {
    complain(addresses.error());
    return wrong_input;
  }
  tl::expected<SafetyNet, std::string> net;
  if (!addresses->empty()) net = SafetyNet::spread({experiment.name, *addresses});
  if (!net) complain(fmt::format("{}: if this program is killed, nothing stops the robots", net.error()));
  std::atomic<bool> stop_asked{false};
  if (net) net->on_stop([&] { stop_asked = true; }, [] { return std::vector<StopResult>{}; });
  const auto ping =
      ping_robots(experiment, 60.0 * request.minutes, [&] { return !interrupted() && !stop_asked.load(); });
  if (net) net->on_stop({}, {});
  if (!ping) {
    if (net) net->done(std::vector<StopResult>{});  // those that were reached have been stopped
    complain(ping.error());
    return device_failed;
  }
  bool good = true;
  double worst = 0.0;
  std::vector<StopResult> stops;  // in the order of `addresses`, as `ping->robots`
  std::map<std::string, comms::RoundTrips> adapters;
  for (const RobotPing::Robot& robot : ping->robots) {
    print(robot, ping->seconds);
    stops.push_back({comms::to_text((*addresses)[stops.size()]), robot.stop_acknowledged,
                     robot.stop_acknowledged ? "" : "it has not acknowledged its stop"});
    worst = std::max(worst, robot.times.quantile_since_start(0.999));
    if (!robot.adapter.empty()) adapters[robot.adapter].add(robot.times);
    if (!robot.stop_acknowledged) complain(robot.name + " has NOT acknowledged its stop");
    good = good && robot.stop_acknowledged && robot.status.exchanges > 0;
  }
  for (const auto& [name, times] : adapters) {
    fmt::print("all over {}: {:.1f} ms median, {:.1f} p99.9\n", name, 1e3 * times.quantile_since_start(0.5),
               1e3 * times.quantile_since_start(0.999));
    for (const std::string& line : histogram(times)) fmt::print("  {}\n", line);
  }
  if (net) net->done(stops);
  const LinksSpec links = proposed_links(worst, experiment.controller.v_max, experiment.period());
  fmt::print("\n[links]\nblind_distance = {:g}\nreply_timeout = {:g}\n", links.blind_distance, links.reply_timeout);
  const int saved = request.save && good ? save(request.words.front(), links) : done;
  return saved != done ? saved : good ? done : device_failed;
}

}  // namespace skein::app
