#include "app/tools/robot_setup.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/experiment/experiment_robots.h"
#include "app/experiment/robots_file.h"

namespace skein::app {
namespace {

std::string plural(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

}  // namespace

bool is_same_robot(const RobotSpec& a, const RobotSpec& b) {
  return a.name == b.name && a.link == b.link && a.address == b.address && a.tag == b.tag;
}

bool RobotSetup::is_bluetooth() const {
  const auto address = comms::parse_link_address(spec.address);
  return spec.is_real() && address && address->kind == comms::LinkKind::rfcomm;
}

KnownRobot known_robot(const comms::BluetoothRobot& robot) {
  KnownRobot known;
  known.spec.name = robot.name;
  known.spec.tag = -1;
  known.spec.link = RobotSpec::Link::device;
  known.spec.address = comms::to_text(robot.link());
  known.spec.adapter = robot.adapter;
  become(known.spec, *core::find_robot_type(core::word(robot.model())));  // types have the names of their motors
  return known;
}

std::vector<RobotSetup> setups_of(const Experiment& experiment, const std::vector<RobotSetup>& before) {
  std::vector<RobotSetup> robots;
  const auto holds = [](const std::vector<RobotSetup>& all, const RobotSpec& spec) {
    return std::find_if(all.begin(), all.end(),
                        [&](const RobotSetup& other) { return is_same_robot(other.spec, spec); });
  };
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const RobotSpec& spec = experiment.robots[i];
    const auto known = holds(before, spec);
    RobotSetup& robot = robots.emplace_back(known == before.end() ? RobotSetup{} : *known);
    robot.spec = spec;
    robot.name = robot_name(experiment, i);
    robot.number = static_cast<int>(i);
  }
  for (const RobotSetup& other : before)
    if (other.number < 0 && std::none_of(robots.begin(), robots.end(), [&](const RobotSetup& robot) {
          return robot.spec.address == other.spec.address;
        }))
      robots.push_back(other);
  return robots;
}

void add_found(std::vector<RobotSetup>& robots, const std::vector<comms::BluetoothRobot>& found) {
  for (const comms::BluetoothRobot& one : found) {
    const KnownRobot known = known_robot(one);
    bool there = false;
    for (RobotSetup& robot : robots) {
      const auto address = comms::parse_link_address(robot.spec.address);
      if (!address || address->device != one.address) continue;
      robot.paired = one.paired;
      there = true;
    }
    if (there) continue;
    RobotSetup& robot = robots.emplace_back();
    robot.spec = known.spec;
    robot.name = one.name;
    robot.paired = one.paired;
  }
}

SetupVerdict verdict_on(const RobotSetup& robot, bool camera) {
  using State = SetupVerdict::State;
  if (robot.may_drive)
    return {State::wrong, "it has NOT acknowledged its stop and may still be driving: lift it, and switch it off"};
  if (!robot.spec.has_link()) return {State::ready, "ready: it is simulated"};
  if (robot.is_bluetooth() && robot.paired == false) return {State::missing, "pair it"};
  if (!robot.pinged) return {State::missing, "ping it"};
  if (!robot.answers)
    return {State::wrong, fmt::format("it does not answer: {}. Is it switched on and in range?", robot.silence)};
  if (robot.battery_low) return {State::wrong, "charge its battery"};
  if (!robot.test_problem.empty())
    return {State::missing, fmt::format("test it again: its test was ended ({})", robot.test_problem)};
  if (!robot.test) return {State::missing, camera ? "test its wheels and its tag" : "test its wheels"};
  if (const std::vector<std::string>& faults = robot.test->faults; !faults.empty())
    return {State::wrong, faults.size() == 1 ? faults.front()
                                             : fmt::format("{}, and {} more: see below", faults.front(),
                                                           plural(faults.size() - 1, "fault"))};
  if (robot.number < 0) return {State::missing, "add it to the experiment"};
  return {State::ready, "ready"};
}

std::vector<std::string> details_of(const RobotSetup& robot) {
  std::vector<std::string> lines;
  if (!robot.version.empty()) lines.push_back(fmt::format("Firmware: {}.", robot.version));
  if (robot.answers && robot.exchanges > 0)
    lines.push_back(fmt::format("It answered {}; {} lost.", plural(robot.exchanges, "question"),
                                robot.lost == 0 ? "none was" : fmt::format("{} were", robot.lost)));
  if (!robot.test) return lines;
  const RobotTestResult& test = *robot.test;
  lines.push_back(fmt::format("Its counters: left {:.0f}, right {:.0f} steps for 10 mm of each wheel.", test.left_steps,
                              test.right_steps));
  if (test.wheel_diameter)
    lines.push_back(fmt::format("The camera measured: wheel_diameter {:.2f} mm, track {:.2f} mm.",
                                1e3 * *test.wheel_diameter, 1e3 * test.track.value_or(none)));
  if (test.watchdog)
    lines.push_back(*test.watchdog == 0.0
                        ? "It has no watchdog: it drives on when nothing is sent to it."
                        : fmt::format("Its watchdog stopped it after {:.2f} s without a command.", *test.watchdog));
  for (const std::string& fault : test.faults) lines.push_back(fmt::format("Fault: {}.", fault));
  for (const std::string& note : test.notes) lines.push_back(fmt::format("Note: {}.", note));
  return lines;
}

tl::expected<SavedSetups, std::string> save(const std::vector<RobotSetup>& robots) {
  SavedSetups saved{known_robots_file({}), 0, {}};
  std::vector<KnownRobot> known;
  std::vector<FoundRobot> found;
  for (const RobotSetup& robot : robots) {
    if (!robot.spec.is_real()) continue;
    if (robot.spec.name.empty()) {
      saved.problems.push_back(
          fmt::format("{} has no name, which a file of robots needs: give it one in the experiment", robot.name));
      continue;
    }
    RobotSpec spec = robot.spec;
    if (const auto address = comms::parse_link_address(spec.address)) spec.address = comms::to_text(*address);
    known.push_back({spec, robot.version});
    if (robot.test && robot.test->faults.empty()) found.push_back({spec, robot.name, values_to_keep(*robot.test)});
  }
  if (known.empty()) {
    if (saved.problems.empty())
      return tl::unexpected(std::string("none of these robots is real, and the file of robots holds real ones"));
    return saved;
  }
  const auto added = add_to_robots_file(saved.file, known);
  if (!added) return tl::unexpected(added.error());
  saved.added = *added;
  if (found.empty()) return saved;
  auto values = save_to_robots_file(saved.file, found);
  if (!values) return tl::unexpected(values.error());
  saved.problems.insert(saved.problems.end(), values->problems.begin(), values->problems.end());
  return saved;
}

}  // namespace skein::app
