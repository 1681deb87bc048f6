#include "app/tools/robot_ping.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <thread>

#include "app/guard/kept_awake.h"
#include "app/guard/safety_net.h"
#include "app/session/robot_lines.h"
#include "comms/link_supervisor.h"

namespace skein::app {
namespace {

// Patient: what is late shall be seen, not be cut off.
constexpr double patience = 5.0;  // [s]

double up_to(double value, double step) {
  return step * std::ceil(value / step - 1e-9);
}

}  // namespace

tl::expected<RobotPing, std::string> ping_robots(const Experiment& experiment, const PingOptions& options) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto since = [](Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  };
  auto lines = open_lines(
      experiment, [](std::size_t, const core::WheelSpeeds&) {}, [&] { return since(start); });
  if (!lines) return tl::unexpected(lines.error());
  if (lines->addresses.empty()) return tl::unexpected(std::string("none of the robots has a link"));
  const auto real = real_robots(experiment);
  if (!real) return tl::unexpected(real.error());
  const auto warn = [&](const std::string& sentence) {
    if (options.warn) options.warn(sentence);
  };
  tl::expected<SafetyNet, std::string> net;
  if (!real->empty()) net = SafetyNet::spread({experiment.name, *real});
  if (!net) warn(unguarded_sentence(net.error()));
  std::optional<KeptAwake> awake;
  if (!real->empty()) awake.emplace(experiment.name).hold(true);
  std::atomic<bool> stop_asked{false};
  const auto keep_on = [&] {
    if (net)
      for (const std::string& sentence : net->alarms()) warn(sentence);
    if (awake)
      if (const auto alarm = awake->alarm()) warn(*alarm);
    return !stop_asked.load() && (!options.keep_on || options.keep_on());
  };
  comms::LinkOptions link_options;
  link_options.reply_timeout = patience;
  link_options.command_silence = experiment.command_silence();
  link_options.heartbeat = link_heartbeat;
  link_options.repeat_speeds = true;
  link_options.ask_version = true;
  link_options.battery_period = link_battery_period;
  comms::LinkSupervisor links(lines->addresses, link_options);
  if (net)
    net->on_stop([&](const std::string&) { stop_asked = true; },
                 [&] {  // robots that are still being pinged are commanded to stand by the end of this
                   std::vector<StopResult> robots;
                   for (const comms::LinkAddress& robot : *real)
                     robots.push_back({comms::to_text(robot), false, "it has not acknowledged its stop"});
                   return robots;
                 });
  const double open_timeout = comms::reach_patience(lines->addresses);
  const auto started =
      options.all ? links.start(open_timeout, keep_on) : links.start_who_answers(open_timeout, keep_on);
  if (!started) {
    if (net) net->on_stop({}, {});
    if (net) net->done(std::vector<StopResult>{});  // those that were reached have been stopped
    return tl::unexpected(started.error());
  }
  RobotPing ping;
  for (const std::size_t i : lines->robots)
    ping.robots.push_back({i, robot_name(experiment, i), experiment.robots[i].adapter, {}, {}, false});
  const auto begun = Clock::now();
  for (std::int64_t k = 0; ping.seconds < options.seconds && keep_on(); ++k) {
    for (std::size_t i = 0; i < ping.robots.size(); ++i) links.command(i, 0, 0);
    ping.seconds = static_cast<double>(k + 1) * experiment.period();
    std::this_thread::sleep_until(
        begun + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(ping.seconds)));
  }
  const std::vector<comms::LinkStatus> status = links.status();
  for (std::size_t i = 0; i < ping.robots.size(); ++i) {
    ping.robots[i].status = status[i];
    ping.robots[i].times = links.round_trips(i);
  }
  if (net) net->on_stop({}, {});
  const std::vector<comms::LinkStatus> closed = links.close(link_close_timeout);
  std::vector<StopResult> stops;  // in the order of `real`
  for (std::size_t i = 0; i < ping.robots.size(); ++i) {
    ping.robots[i].stop_acknowledged = closed[i].stop_acknowledged;
    if (!experiment.robots[ping.robots[i].robot].is_real()) continue;
    const bool stands = closed[i].stop_acknowledged || !ping.robots[i].answered();  // nothing has reached it
    stops.push_back({comms::to_text((*real)[stops.size()]), stands, stands ? "" : "it has not acknowledged its stop"});
  }
  if (net) net->done(stops);
  return ping;
}

LinksSpec proposed_links(double rtt_p999, double speed, double period) {
  LinksSpec links;
  links.blind_distance = std::clamp(up_to(2.0 * speed * (2.0 * rtt_p999 + period), 0.005), 0.02, 1.0);
  links.reply_timeout = std::clamp(up_to(3.0 * rtt_p999, 0.05), 0.2, 10.0);
  return links;
}

std::vector<std::string> histogram(const comms::RoundTrips& times) {
  constexpr std::array<double, 11> ends{0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 1e9};  // [s]
  std::array<double, ends.size()> counts{};
  for (std::size_t k = 0; k < comms::RoundTrips::class_count; ++k) {
    const auto bin =
        std::find_if(ends.begin(), ends.end(), [&](double end) { return comms::RoundTrips::end_of(k) <= end * 1.03; });
    counts[static_cast<std::size_t>(bin - ends.begin())] += static_cast<double>(times.classes()[k]);
  }
  const double all = std::accumulate(counts.begin(), counts.end(), 0.0);
  std::vector<std::string> lines;
  if (all == 0.0) return lines;
  const auto any = [](double count) { return count > 0.0; };
  const auto first = std::find_if(counts.begin(), counts.end(), any) - counts.begin();
  const auto last = counts.rend() - std::find_if(counts.rbegin(), counts.rend(), any);
  for (auto k = static_cast<std::size_t>(first); k < static_cast<std::size_t>(last); ++k) {
    const double share = counts[k] / all;
    const std::string to = k + 1 == ends.size() ? "more" : fmt::format("{:g} ms", 1e3 * ends[k]);
    lines.push_back(fmt::format("{:>6g} .. {:<8} {:<40} {:.2f} %", k == 0 ? 0.0 : 1e3 * ends[k - 1], to,
                                std::string(static_cast<std::size_t>(std::lround(40.0 * share)), '#'), 100.0 * share));
  }
  return lines;
}

}  // namespace skein::app
