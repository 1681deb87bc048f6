#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <future>
#include <iostream>
#include <vector>

#include "app/cli/commands.h"
#include "app/experiment/experiment_robots.h"
#include "app/experiment/known_robots.h"
#include "app/guard/robot_addresses.h"
#include "app/guard/run_marker.h"
#include "app/guard/safety_net.h"
#include "app/guard/stop_run.h"
#include "app/guard/stop_socket.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

void print(const std::vector<Problem>& problems) {
  print_error(messages(problems) + "\n");
}

std::string not_known(const std::string& name, const std::string& path, const std::string& names) {
  return fmt::format(
      "{}: is not a known robot; allowed: an address (rfcomm:ADDRESS/CHANNEL, serial:DEVICE, tcp:HOST, udp:HOST), an "
      "experiment or a file of robots (.toml), or a name in {}:{}",
      name, path,
      !names.empty()     ? names
      : fs::exists(path) ? " it has none"
                         : " there is no such file");
}

std::string names_of(const std::vector<comms::LinkAddress>& robots) {
  std::string names;
  for (const comms::LinkAddress& robot : robots) names += fmt::format(" \"{}\"", robot.name);
  return names;
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
    become(spec, type_spoken(address));
    return spec;
  }
  std::optional<RobotSpec> by_name(const std::string& name) {
    if (fs::exists(path_) && !read()) return {};
    for (const KnownRobot& robot : robots_)
      if (robot.spec.name == name) return robot.spec;
    std::string names;
    for (const KnownRobot& robot : robots_) names += fmt::format(" \"{}\"", robot.spec.name);
    complain(not_known(name, path_, names));
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

/// Robots that are to be stopped, and how that went.
class Stops {
 public:
  void add(const comms::LinkAddress& robot) {
    if (!holds(wanted_, robot)) wanted_.push_back(robot);
  }
  bool any() const noexcept { return !wanted_.empty(); }

  /// Through the runs and guards that hold them, all of these runs where `every_run`; then the remaining robots over a
  /// connection. True: all are known to stand.
  bool carry_out(bool every_run, std::vector<RunMarker> runs) {
    if (!every_run) resolve_names();
    std::erase_if(runs, [&](const RunMarker& run) {
      const auto mine = [&](const comms::LinkAddress& robot) { return holds(wanted_, robot); };
      return run.robots.empty() || (!every_run && std::none_of(run.robots.begin(), run.robots.end(), mine));
    });
    std::vector<std::future<StoppedRun>> stopped;
    stopped.reserve(runs.size());
    for (const RunMarker& run : runs)
      stopped.push_back(std::async(std::launch::async | std::launch::deferred, [&run] { return stop_run(run); }));
    if (every_run) resolve_names();  // a name service that does not answer must not hold up the others
    bool all = true;
    std::vector<comms::LinkAddress> by_hand = wanted_;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const StoppedRun result = stopped[i].get();
      for (const comms::LinkAddress& robot : runs[i].robots) {
        std::erase_if(by_hand, [&](const comms::LinkAddress& other) { return same(robot, other); });
        if (result.by_hand) by_hand.push_back(robot);
      }
      if (result.by_hand) continue;
      for (const StopResult& robot : result.robots) all = say(robot) && all;
    }
    all = stop_all(by_hand) && all;
    for (std::size_t i = 0; all && i < runs.size(); ++i)
      if (!runs[i].alive()) runs[i].forget();
    return all;
  }

 private:
  void resolve_names() {
    for (comms::LinkAddress& robot : wanted_)
      if (auto resolved = comms::resolve(robot)) robot = *std::move(resolved);
  }
  static bool same(const comms::LinkAddress& a, const comms::LinkAddress& b) {
    return comms::to_text(a) == comms::to_text(b);
  }
  static bool holds(const std::vector<comms::LinkAddress>& all, const comms::LinkAddress& robot) {
    return std::any_of(all.begin(), all.end(), [&](const comms::LinkAddress& other) { return same(other, robot); });
  }
  static bool say(const StopResult& robot) {
    if (robot.stopped)
      print_out(fmt::format("{}: stopped\n", robot.address));
    else
      complain(fmt::format("{}: NOT known to be stopped: {}", robot.address, robot.reason));
    return robot.stopped;
  }
  std::vector<comms::LinkAddress> wanted_;
};

/// Robots of a file into `stops`, whatever is wrong with it; what is goes to `problems`.
void add_all_of(const std::string& file, Stops& stops, std::vector<std::string>& problems) {
  const RobotAddresses found = robot_addresses(file);
  for (const comms::LinkAddress& robot : found.robots) stops.add(robot);
  problems.insert(problems.end(), found.problems.begin(), found.problems.end());
  if (found.robots.empty() && found.problems.empty())
    problems.push_back(fmt::format("skein: {}: no robot in it has a link", file));
}

}  // namespace

void look_after_bad_ends() {
  const std::vector<RunMarker> runs = bad_ends();
  bool any = false;
  for (const RunMarker& run : runs) {
    if (run.robots.empty()) {
      run.forget();  // a simulation
      continue;
    }
    any = true;
    const bool guarded = listens(run.socket());
    complain(fmt::format("the run \"{}\" ended badly, and its robots may still be driving: {}{}", run.experiment,
                         run.names(), guarded ? " (its guard keeps trying to stop them)" : ""));
  }
  if (!any) return;
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    complain("to stop them: skein robots stop; to end this message: skein robots forget");
    return;
  }
  print_error("skein: stop them now? [Y/n] ");
  std::string answer;
  std::getline(std::cin, answer);
  if (!answer.starts_with('n') && !answer.starts_with('N')) (void)Stops{}.carry_out(/*every_run=*/true, runs);
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
      const auto linked = [](const RobotSpec& robot) { return robot.has_link(); };
      if (std::none_of(experiment->robots.begin(), experiment->robots.end(), linked)) {
        complain(fmt::format("{}: no robot in it has a link", word));
        return {};
      }
      named.robots.insert(named.robots.end(), experiment->robots.begin(), experiment->robots.end());
      if (words.size() == 1) named.experiment = std::move(experiment);
    } else {
      const bool address = comms::is_link_address(word);
      const auto parsed = comms::parse_link_address(word);
      if (address && !parsed) return complain(parsed.error()), std::nullopt;
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
      complain("no robot is known yet: `skein robots scan --save` writes this file");
    return wrong_input;
  }
  std::vector<std::vector<std::string>> rows{
      {"name", "link", "adapter", "tag", "model", "wheel mm", "track mm", "version"}};
  const auto in_mm = [](double length) { return fmt::format("{:.2f}", 1e3 * length); };
  for (const auto& [spec, version] : *known)
    rows.push_back({spec.name, spec.address, spec.adapter.empty() ? "-" : spec.adapter,
                    spec.tag < 0 ? "-" : std::to_string(spec.tag), std::string(spec.type->name),
                    in_mm(spec.drive.wheel_diameter), in_mm(spec.drive.track), version.empty() ? "-" : version});
  fmt::print("# {}\n{}", shown(path), table(rows));
  return done;
}

int stop_robots(const std::vector<std::string>& words, const std::string& file) {
  std::signal(SIGHUP, SIG_IGN);  // a terminal that closes must not keep any robot from being stopped
  const std::string path = known_robots_file(file);
  Stops stops;
  std::vector<std::string> problems;
  for (const std::string& word : words) {
    const auto address = comms::parse_link_address(word);
    if (word.ends_with(".toml")) {
      add_all_of(word, stops, problems);
    } else if (address) {
      comms::LinkAddress robot = *address;
      for (const comms::LinkAddress& known : robot_addresses(path).robots)  // an address needs no file, but the adapter
        if (comms::to_text(known) == comms::to_text(robot)) robot = known;
      stops.add(robot);
    } else {
      const RobotAddresses known = robot_addresses(path);
      const auto named = std::find_if(known.robots.begin(), known.robots.end(),
                                      [&](const comms::LinkAddress& robot) { return robot.name == word; });
      if (named != known.robots.end()) {
        stops.add(*named);
        continue;
      }
      problems.insert(problems.end(), known.problems.begin(), known.problems.end());
      const bool is_address = comms::is_link_address(word);
      problems.push_back("skein: " + (is_address ? address.error() : not_known(word, path, names_of(known.robots))));
    }
  }
  const bool all_known = words.empty();
  if (all_known && (!file.empty() || fs::exists(path))) {
    const RobotAddresses known = robot_addresses(path);
    for (const comms::LinkAddress& robot : known.robots) stops.add(robot);
    problems.insert(problems.end(), known.problems.begin(), known.problems.end());
  }
  const FoundMarkers found = find_markers();
  if (!found.unreadable.empty()) problems.push_back("skein: " + found.unreadable);
  const bool runs = all_known && !found.runs.empty();
  if (all_known && !runs && !stops.any() && problems.empty())
    print_out(
        fmt::format("no run is active or has left a robot behind, and no robot is known: there is no {}\n", path));
  const bool all = stops.carry_out(/*every_run=*/all_known, found.runs);
  // Only now: a mistake in a file must not keep any robot from being stopped.
  for (const std::string& problem : problems) print_error(shown(problem) + "\n");
  if (problems.empty())
    for (const std::string& word : words)
      if (word.ends_with(".toml")) (void)named_robots({word}, file);  // says what else is wrong with it
  if (!all || !found.unreadable.empty()) return device_failed;
  return problems.empty() ? done : wrong_input;
}

}  // namespace skein::app
