#include "app/tools/robot_ping.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <thread>

#include "app/guard/safety_net.h"
#include "comms/link_supervisor.h"

namespace skein::app {
namespace {

constexpr double open_timeout = 15.0, close_timeout = 1.0;  // [s]
constexpr double heartbeat = 0.05;                          // [s]
// Patient: what is late shall be seen, not be cut off.
constexpr double patience = 5.0;  // [s]

double up_to(double value, double step) {
  return step * std::ceil(value / step - 1e-9);
}

}  // namespace

tl::expected<RobotPing, std::string> ping_robots(const Experiment& experiment, double seconds,
                                                 const std::function<bool()>& keep_on) {
  RobotPing ping;
  std::vector<comms::LinkAddress> addresses;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    if (!experiment.robots[i].is_real()) continue;
    auto address = link_of(experiment, i);
    if (!address) return tl::unexpected(address.error());
    RobotPing::Robot& robot = ping.robots.emplace_back();
    robot.name = robot_name(experiment, i);
    robot.adapter = address->adapter;
    addresses.push_back(std::move(*address));
  }
  if (addresses.empty()) return tl::unexpected(std::string("none of the robots has a link"));
  comms::LinkOptions options;
  options.reply_timeout = patience;
  options.command_silence = experiment.command_silence();
  options.heartbeat = heartbeat;
  options.repeat_speeds = true;
  comms::LinkSupervisor links(addresses, options);
  if (auto started = links.start(open_timeout); !started) return tl::unexpected(started.error());
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  const auto after = [start](double s) {
    return start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
  };
  for (std::int64_t k = 0; ping.seconds < seconds && keep_on(); ++k) {
    for (std::size_t i = 0; i < addresses.size(); ++i) links.command(i, 0, 0);
    ping.seconds = static_cast<double>(k + 1) * experiment.period();
    std::this_thread::sleep_until(after(ping.seconds));
  }
  const std::vector<comms::LinkStatus> status = links.status();
  for (std::size_t i = 0; i < ping.robots.size(); ++i) {
    ping.robots[i].status = status[i];
    ping.robots[i].times = links.round_trips(i);
  }
  const std::vector<comms::LinkStatus> closed = links.close(close_timeout);
  for (std::size_t i = 0; i < ping.robots.size(); ++i) ping.robots[i].stop_acknowledged = closed[i].stop_acknowledged;
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
