#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <vector>

#include "app/cli/commands.h"
#include "app/experiment/known_robots.h"
#include "app/run/exit_status.h"
#include "app/session/safety_net.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

void print(const std::vector<Problem>& problems) {
  for (const Problem& problem : problems) fmt::print(stderr, "{}\n", problem.message());
}

/// The file of robots, read once and only where a word asks for it.
class Known {
 public:
  explicit Known(std::string path) : path_(std::move(path)) {}

  /// Where the file says more than the address, its robot; else the address alone.
  std::optional<RobotSpec> by_link(const comms::LinkAddress& address) {
    if (fs::exists(path_) && !read()) return {};
    for (const KnownRobot& robot : robots_)
      if (robot.spec.address == comms::to_text(address)) return robot.spec;
    RobotSpec spec;
    spec.tag = -1;
    spec.link = RobotSpec::Link::device;
    spec.address = comms::to_text(address);
    spec.motor = core::MotorModel::epuck2;
    return spec;
  }
  std::optional<RobotSpec> by_name(const std::string& name) {
    if (fs::exists(path_) && !read()) return {};
    for (const KnownRobot& robot : robots_)
      if (robot.spec.name == name) return robot.spec;
    std::string names;
    for (const KnownRobot& robot : robots_) names += fmt::format(" \"{}\"", robot.spec.name);
    fmt::print(stderr,
               "skein: {}: is no robot that is known; allowed: an address (rfcomm:ADDRESS/CHANNEL, serial:DEVICE, "
               "tcp:HOST), an experiment or a file of robots (.toml), or a name in {}:{}\n",
               name, path_,
               !names.empty()      ? names
               : fs::exists(path_) ? " it has none"
                                   : " there is no such file");
    return {};
  }

 private:
  bool read() {
    if (read_) return true;
    auto robots = load_known_robots(path_);
    if (!robots) return print(robots.error()), false;
    robots_ = std::move(*robots);
    return read_ = true;
  }
  std::string path_;
  std::vector<KnownRobot> robots_;
  bool read_ = false;
};

std::optional<std::vector<RobotSpec>> all_of(const std::string& file) {
  const auto known = load_known_robots(file);
  if (!known) return print(known.error()), std::nullopt;
  std::vector<RobotSpec> robots;
  for (const KnownRobot& robot : *known) robots.push_back(robot.spec);
  return robots;
}

std::optional<std::vector<comms::LinkAddress>> addresses_of(const std::vector<RobotSpec>& robots) {
  Experiment experiment;
  experiment.robots = robots;
  auto addresses = real_robots(experiment);
  if (addresses) return *std::move(addresses);
  fmt::print(stderr, "skein: {}\n", addresses.error());
  return {};
}

}  // namespace

void look_after_bad_ends() {
  const std::vector<RunMarker> runs = bad_ends();
  if (runs.empty()) return;
  for (const RunMarker& run : runs)
    fmt::print(stderr, "skein: the run \"{}\" ended badly, and its robots may still be driving: {}\n", run.experiment,
               run.names());
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    fmt::print(stderr, "skein: to stop them: skein robots stop\n");
    return;
  }
  fmt::print(stderr, "skein: stop them now? [Y/n] ");
  std::string answer;
  std::getline(std::cin, answer);
  if (!answer.starts_with('n') && !answer.starts_with('N')) (void)stop_left_behind(runs);
}

std::optional<NamedRobots> named_robots(const std::vector<std::string>& words, const std::string& file) {
  Known known(known_robots_file(file));
  NamedRobots named;
  for (const std::string& word : words) {
    if (word.ends_with(".toml") && is_file_of_robots(word)) {
      const auto robots = all_of(word);
      if (!robots) return {};
      named.robots.insert(named.robots.end(), robots->begin(), robots->end());
    } else if (word.ends_with(".toml")) {
      auto experiment = load({word, {}});
      if (!experiment) return {};
      const auto linked = [](const RobotSpec& robot) { return robot.link != RobotSpec::Link::sim; };
      if (std::none_of(experiment->robots.begin(), experiment->robots.end(), linked)) {
        fmt::print(stderr, "skein: {}: no robot in it has a link\n", word);
        return {};
      }
      named.robots.insert(named.robots.end(), experiment->robots.begin(), experiment->robots.end());
      if (words.size() == 1) named.experiment = std::move(experiment);
    } else {
      const bool address = word.starts_with("rfcomm:") || word.starts_with("serial:") || word.starts_with("tcp:");
      const auto parsed = comms::parse_link_address(word);
      if (address && !parsed) return fmt::print(stderr, "skein: {}\n", parsed.error()), std::nullopt;
      const auto robot = address ? known.by_link(*parsed) : known.by_name(word);
      if (!robot) return {};
      named.robots.push_back(*robot);
    }
  }
  return named;
}

int list_robots(const std::string& file) {
  const std::string path = known_robots_file(file);
  const auto known = load_known_robots(path);
  if (!known) {
    print(known.error());
    if (file.empty() && !fs::exists(path))
      fmt::print(stderr, "skein: no robot is known yet: `skein robots scan --save` writes this file\n");
    return wrong_input;
  }
  fmt::print("# {}\n{:<16} {:<32} {:<8} {:>4} {:<7} {:>8} {:>8} {}\n", path, "name", "link", "adapter", "tag", "model",
             "wheel mm", "track mm", "version");
  for (const auto& [spec, version] : *known)
    fmt::print("{:<16} {:<32} {:<8} {:>4} {:<7} {:>8.2f} {:>8.2f} {}\n", spec.name, spec.address,
               spec.adapter.empty() ? "-" : spec.adapter, spec.tag < 0 ? "-" : std::to_string(spec.tag),
               spec.motor == core::MotorModel::epuck1 ? "epuck1" : "epuck2", 1e3 * spec.drive.wheel_diameter,
               1e3 * spec.drive.track, version.empty() ? "-" : version);
  return done;
}

int stop_robots(const std::vector<std::string>& words, const std::string& file) {
  if (!words.empty()) {
    const auto named = named_robots(words, file);
    const auto addresses = named ? addresses_of(named->robots) : std::nullopt;
    if (!addresses) return wrong_input;
    if (addresses->empty()) {
      fmt::print(stderr, "skein: none of these robots is real\n");
      return wrong_input;
    }
    return stop_all(*addresses) ? done : device_failed;
  }
  const std::vector<RunMarker> runs = bad_ends();
  int status = stop_left_behind(runs) ? done : device_failed;
  const std::string path = known_robots_file(file);
  if (file.empty() && !fs::exists(path)) {
    if (runs.empty()) fmt::print("no run has left a robot behind, and no robot is known: there is no {}\n", path);
    return status;
  }
  const auto robots = all_of(path);
  auto addresses = robots ? addresses_of(*robots) : std::nullopt;
  if (!addresses) return wrong_input;
  for (const RunMarker& run : runs)  // these have been seen to
    std::erase_if(*addresses, [&](const comms::LinkAddress& known) {
      return std::any_of(run.robots.begin(), run.robots.end(),
                         [&](const comms::LinkAddress& left) { return comms::to_text(left) == comms::to_text(known); });
    });
  return stop_all(*addresses) ? status : device_failed;
}

}  // namespace skein::app
