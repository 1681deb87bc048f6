#include <fmt/format.h>

#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <vector>

#include "app/command_line.h"
#include "app/commands.h"
#include "app/safety_net.h"
#include "comms/robot_check.h"

namespace skein::app {
namespace {

constexpr double reach_timeout = 15.0;  // a Bluetooth connection takes a few seconds, and may meet a busy robot [s]

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
    const auto robots = real_robots(*experiment);
    if (!robots) {
      fmt::print(stderr, "skein: {}: {}\n", word, robots.error());
      return {};
    }
    addresses.insert(addresses.end(), robots->begin(), robots->end());
    if (robots->empty()) {
      fmt::print(stderr, "skein: {}: no robot in it is real\n", word);
      return {};
    }
  }
  return addresses;
}

/// Stops the robots of every run that ended badly, and forgets the runs whose robots stand.
int stop_left_behind() {
  const std::vector<RunMarker> runs = bad_ends();
  if (runs.empty()) fmt::print("no run has left a robot behind\n");
  int status = done;
  for (const RunMarker& run : runs) {
    if (stop_all(run.robots))
      std::filesystem::remove(run.path);
    else
      status = device_failed;
  }
  return status;
}

}  // namespace

void look_after_bad_ends() {
  const std::vector<RunMarker> runs = bad_ends();
  if (runs.empty()) return;
  for (const RunMarker& run : runs) {
    std::string names;
    for (const comms::LinkAddress& robot : run.robots) names += ' ' + comms::to_text(robot);
    fmt::print(stderr, "skein: the run \"{}\" ended badly, and its robots may still be driving:{}\n", run.experiment,
               names);
  }
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    fmt::print(stderr, "skein: to stop them: skein robots stop\n");
    return;
  }
  fmt::print(stderr, "skein: stop them now? [Y/n] ");
  std::string answer;
  std::getline(std::cin, answer);
  if (!answer.starts_with('n') && !answer.starts_with('N')) (void)stop_left_behind();
}

int stop_robots(const std::vector<std::string>& words) {
  if (words.empty()) return stop_left_behind();
  const auto addresses = addresses_of(words);
  if (!addresses) return wrong_input;
  return stop_all(*addresses) ? done : device_failed;
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
