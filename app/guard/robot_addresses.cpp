#include "app/guard/robot_addresses.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string_view>

#include <toml++/toml.h>

#include "app/experiment/text_file.h"
#include "app/experiment/toml_table.h"
#include "core/kinematics/robot_type.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

void add(RobotAddresses& found, const std::string& link, const std::string& model, const std::string& adapter,
         const std::string& name, const std::string& place) {
  if (link == "sim" || link == "loopback") return;
  auto address = comms::parse_link_address(link);
  if (!address) return found.problems.push_back(fmt::format("{}: {}", place, address.error()));
  // Where model and link disagree, the link is believed: that robot is tried.
  if (const core::RobotType* const type = core::find_robot_type(model))
    if (auto spoken = comms::spoken_by(*address, type->protocol)) address = std::move(spoken);
  address->adapter = adapter;
  address->name = name;
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
  std::string line, link, model, adapter, name, place;
  const auto end_robot = [&] {
    if (!link.empty()) add(found, link, model, adapter, name, place);
    link.clear(), model.clear(), adapter.clear(), name.clear();
  };
  for (int number = 1; std::getline(lines, line); ++number) {
    if (const std::size_t begin = line.find_first_not_of(" \t"); begin != line.npos && line[begin] == '[') end_robot();
    if (auto value = value_of(line, "link")) {
      if (!link.empty()) end_robot();  // the line that begins a robot is damaged
      link = *value;
      place = fmt::format("{}:{}", file, number);
    }
    if (auto value = value_of(line, "model")) model = *value;
    if (auto value = value_of(line, "adapter")) adapter = *value;
    if (auto value = value_of(line, "name")) name = *value;
  }
  end_robot();
}

void read_document(const toml::table& document, const std::string& file, RobotAddresses& found) {
  RobotAddresses known;
  if (const auto robots_file = document["robots_file"].value<std::string>())
    known = robot_addresses((fs::path(file).parent_path() / *robots_file).string());
  found.problems.insert(found.problems.end(), known.problems.begin(), known.problems.end());
  const toml::array* const robots = document["robot"].as_array();
  for (std::size_t i = 0; robots && i < robots->size(); ++i) {
    const toml::table* const robot = robots->get(i)->as_table();
    if (!robot) continue;
    const std::string name = (*robot)["name"].value_or(std::string{});
    std::string adapter = (*robot)["adapter"].value_or(std::string{});
    const auto listed = std::find_if(known.robots.begin(), known.robots.end(),
                                     [&](const comms::LinkAddress& other) { return other.name == name; });
    const bool is_listed = !name.empty() && listed != known.robots.end();
    if (adapter.empty() && is_listed) adapter = listed->adapter;
    const std::string link = (*robot)["link"].value_or(is_listed ? comms::to_text(*listed) : std::string{});
    const std::string defaults = document["robot_defaults"]["model"].value_or(std::string{});
    if (!link.empty())
      add(found, link, (*robot)["model"].value_or(defaults), adapter, name,
          fmt::format("{}: robot.{}.link", file, i + 1));
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
