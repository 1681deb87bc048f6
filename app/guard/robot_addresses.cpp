#include "app/guard/robot_addresses.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include <toml++/toml.h>

#include "app/experiment/text_file.h"
#include "app/experiment/toml_table.h"
#include "core/kinematics/robot_type.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

/// What names a robot, as the file has it; empty: it does not say.
struct Keys {
  std::string link, model, adapter, name;

  static Keys of(const toml::table& table) {
    const auto text = [&table](std::string_view key) { return table[key].value_or(std::string{}); };
    return {text("link"), text("model"), text("adapter"), text("name")};
  }
  /// With what [robot_defaults] says where this says nothing.
  Keys over(const Keys& defaults) const {
    const auto or_else = [](const std::string& own, const std::string& other) { return own.empty() ? other : own; };
    return {or_else(link, defaults.link), or_else(model, defaults.model), or_else(adapter, defaults.adapter), name};
  }
};

void add(RobotAddresses& found, const Keys& robot, const std::string& place) {
  if (robot.link.empty() || robot.link == "sim" || robot.link == "loopback") return;
  auto address = comms::parse_link_address(robot.link);
  if (!address) return found.problems.push_back(fmt::format("{}: {}", place, address.error()));
  // Where model and link disagree, the link is believed: that robot is tried.
  if (const core::RobotType* const type = core::find_robot_type(robot.model))
    if (auto spoken = comms::spoken_by(*address, type->protocol)) address = std::move(spoken);
  address->adapter = robot.adapter;
  address->name = robot.name;
  found.robots.push_back(std::move(*address));
}

/// The text in quotes behind `key =` at the beginning of a line.
std::optional<std::string> value_of(std::string_view line, std::string_view key) {
  const auto skip = [&line] { line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size())); };
  skip();
  if (!line.starts_with(key)) return {};
  line.remove_prefix(key.size());
  skip();
  if (!line.starts_with('=')) return {};
  line.remove_prefix(1);
  skip();
  if (!line.starts_with('"') && !line.starts_with('\'')) return {};
  const std::size_t end = line.find(line.front(), 1);
  if (end == line.npos) return {};
  return std::string(line.substr(1, end - 1));
}

void read_lines(const std::string& text, const std::string& file, RobotAddresses& found) {
  std::istringstream lines(text);
  std::string line, place;
  Keys defaults, robot;
  bool in_defaults = false;
  const auto end_robot = [&] {
    if (!robot.link.empty()) add(found, robot.over(defaults), place);
    robot = {};
  };
  for (int number = 1; std::getline(lines, line); ++number) {
    if (const std::size_t begin = line.find_first_not_of(" \t"); begin != line.npos && line[begin] == '[') {
      end_robot();
      in_defaults = std::string_view(line).substr(begin).starts_with("[robot_defaults");
    }
    if (auto value = value_of(line, "link")) {
      if (!robot.link.empty()) end_robot();  // the line that begins a robot is damaged
      robot.link = *value;
      place = fmt::format("{}:{}", file, number);
    }
    Keys& keys = in_defaults ? defaults : robot;
    if (auto value = value_of(line, "model")) keys.model = *value;
    if (auto value = value_of(line, "adapter")) keys.adapter = *value;
    if (auto value = value_of(line, "name")) robot.name = *value;
  }
  end_robot();
}

void read_document(const toml::table& document, const std::string& file, RobotAddresses& found) {
  RobotAddresses known;
  if (const auto robots_file = document["robots_file"].value<std::string>())
    known = robot_addresses((fs::path(file).parent_path() / *robots_file).string());
  found.problems.insert(found.problems.end(), known.problems.begin(), known.problems.end());
  const toml::table* const table = document["robot_defaults"].as_table();
  const Keys defaults = table ? Keys::of(*table) : Keys{};
  const toml::array* const robots = document["robot"].as_array();
  for (std::size_t i = 0; robots && i < robots->size(); ++i) {
    const toml::table* const robot = robots->get(i)->as_table();
    if (!robot) continue;
    Keys keys = Keys::of(*robot);
    const auto listed = std::find_if(known.robots.begin(), known.robots.end(),
                                     [&](const comms::LinkAddress& other) { return other.name == keys.name; });
    if (!keys.name.empty() && listed != known.robots.end())
      keys = keys.over({comms::to_text(*listed), {}, listed->adapter, {}});
    add(found, keys.over(defaults), fmt::format("{}: robot.{}.link", file, i + 1));
  }
}

}  // namespace

RobotAddresses robot_addresses(const std::string& file) {
  RobotAddresses found;
  const auto text = read_text(file);
  if (!text) {
    for (const Problem& problem : text.error()) found.problems.push_back(problem.message());
    return found;
  }
  if (const auto document = parse_toml(*text, file)) {
    read_document(*document, file, found);
  } else {
    for (const Problem& problem : document.error()) found.problems.push_back(problem.message());
    read_lines(*text, file, found);
  }
  return found;
}

}  // namespace skein::app
