#include <fmt/format.h>

#include <future>
#include <vector>

#include "app/command_line.h"
#include "app/commands.h"
#include "comms/link_supervisor.h"
#include "comms/robot_check.h"

namespace skein::app {
namespace {

constexpr double reach_timeout = 15.0;  // a Bluetooth connection takes a few seconds, and may meet a busy robot [s]
constexpr double stop_timeout = 2.0;    // [s]

/// The robots that the words name: a link address each, or the real robots of an experiment file. Nothing, with the
/// reason on stderr, if one of the words names none.
std::optional<std::vector<comms::LinkAddress>> addresses_of(const std::vector<std::string>& words) {
  std::vector<comms::LinkAddress> addresses;
  for (const std::string& word : words) {
    if (!word.ends_with(".toml")) {
      const auto address = comms::parse_link_address(word);
      if (!address) {
        fmt::print(stderr, "skein: {}\n", address.error());
        return {};
      }
      addresses.push_back(*address);
      continue;
    }
    const auto experiment = load({word, {}});
    if (!experiment) return {};
    const std::size_t before = addresses.size();
    for (std::size_t i = 0; i < experiment->robots.size(); ++i) {
      const RobotSpec& robot = experiment->robots[i];
      if (robot.simulated()) continue;
      auto address = comms::parse_link_address(robot.address);
      if (!address) {
        fmt::print(stderr, "skein: {}: robot {}: {}\n", word, i + 1, address.error());
        return {};
      }
      address->adapter = robot.adapter;
      addresses.push_back(*address);
    }
    if (addresses.size() == before) {
      fmt::print(stderr, "skein: {}: no robot in it is real\n", word);
      return {};
    }
  }
  return addresses;
}

/// Connects, stops, and says how that went; empty: the robot has acknowledged.
std::string stop_one(const comms::LinkAddress& address) {
  comms::LinkSupervisor link({address}, {.close_timeout = stop_timeout});  // one each: none waits for another
  const auto started = link.start(reach_timeout);
  const comms::LinkStatus status = link.close(stop_timeout).at(0);
  if (status.stop_acknowledged) return {};
  return started || !status.reason.empty() ? status.reason : started.error();
}

}  // namespace

int stop_robots(const std::vector<std::string>& words) {
  const auto addresses = addresses_of(words);
  if (!addresses) return wrong_input;
  std::vector<std::future<std::string>> stops;
  for (const comms::LinkAddress& address : *addresses)
    stops.push_back(std::async(std::launch::async, [&address] { return stop_one(address); }));
  int status = done;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const std::string failure = stops[i].get();
    const std::string name = comms::to_text((*addresses)[i]);
    if (failure.empty()) {
      fmt::print("{}: stopped\n", name);
    } else {
      fmt::print(stderr, "skein: {}: NOT known to be stopped: {}\n", name, failure);
      status = device_failed;
    }
  }
  return status;
}

int test_robot(const std::string& word) {
  const auto address = comms::parse_link_address(word);
  if (!address) {
    fmt::print(stderr, "skein: {}\n", address.error());
    return wrong_input;
  }
  const auto checked = comms::check_robot(*address, reach_timeout);
  if (!checked) {
    fmt::print(stderr, "skein: {}: {}\n", word, checked.error());
    return device_failed;
  }
  const auto said = [](const std::string& text) { return text.empty() ? "not said" : text; };
  fmt::print("robot: {}\nversion: {}\nbattery: {}\nleft_steps: {}\nright_steps: {}\nfaults: {}\n", word,
             said(checked->version), comms::to_text(checked->battery), checked->left_steps, checked->right_steps,
             checked->faults.size());
  for (const std::string& fault : checked->faults) fmt::print(stderr, "skein: {}: {}\n", word, fault);
  return checked->faults.empty() ? done : device_failed;
}

}  // namespace skein::app
