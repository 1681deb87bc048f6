#include "app/experiment/known_robots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "app/experiment/experiment_robots.h"
#include "app/experiment/text_file.h"
#include "app/experiment/toml_places.h"
#include "app/experiment/toml_table.h"
#include "app/run/home.h"
#include "comms/link_address.h"
#include "comms/link_status.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

KnownRobot read_known(TomlTable& t, Problems& problems) {
  RobotKeys keys;
  keys.spec.tag = -1;
  for (const char* key : {"name", "link"}) t.require(key, "the robot's name and its link");
  read_name_and_tag(t, keys.spec);
  read_robot(t, keys, problems);
  if (const toml::node* const link = t.node("link"); link && keys.spec.simulated() && link->is_string()) {
    const std::string text = *link->value<std::string>();
    if (text == "sim" || text == "loopback")
      t.refuse("link", *link, "the address of a real robot: simulation is set in the experiment");
  }
  KnownRobot robot{finished(keys, problems), {}};
  if (const auto link = comms::parse_link_address(robot.spec.address)) robot.spec.address = comms::to_text(*link);
  t.line("version", robot.version, comms::longest_version);
  t.finish();
  return robot;
}

/// What the document of a file of robots says.
tl::expected<std::vector<KnownRobot>, std::vector<Problem>> read_document(const toml::table& document,
                                                                          const std::string& path) {
  Problems problems(document, path);
  TomlTable top(&document, "", problems);
  std::vector<KnownRobot> robots;
  std::map<std::string, std::size_t> names, links;
  for (TomlTable& t : top.tables("robot")) {
    const KnownRobot& robot = robots.emplace_back(read_known(t, problems));
    const auto link = comms::parse_link_address(robot.spec.address);
    for (const auto& [key, value, same, seen] :
         {std::tuple("name", &robot.spec.name, robot.spec.name, &names),
          std::tuple("link", &robot.spec.address, link ? comms::canonical_text(*link) : std::string(), &links)})
      if (const auto [other, unique] = seen->emplace(same, robots.size()); !unique && !value->empty())
        problems.add(t.full(key),
                     fmt::format("found \"{}\", which robot {} already has, allowed: a different one for each robot",
                                 *value, other->second));
  }
  top.finish();
  if (!problems.empty()) return tl::unexpected(std::move(problems).sorted());
  return robots;
}

tl::expected<toml::table, std::vector<Problem>> read_file(const std::string& path) {
  const auto text = read_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_toml(*text, path, FileKind::robots);
}

/// The table of the robot that is called so; null: none is.
toml::table* find(toml::table& document, std::string_view name) {
  toml::array* const robots = document["robot"].as_array();
  for (std::size_t i = 0; robots && i < robots->size(); ++i)
    if (toml::table* const robot = (*robots)[i].as_table(); robot && (*robot)["name"].value<std::string_view>() == name)
      return robot;
  return nullptr;
}

std::string names_of(const std::vector<KnownRobot>& robots) {
  std::string names;
  for (const KnownRobot& robot : robots) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", robot.spec.name);
  return names.empty() ? "none, the file has no robots" : names;
}

/// The robots of the experiment take over what they do not say themselves.
void merge(toml::table& document, toml::table& file, const std::string& path, const std::vector<KnownRobot>& known,
           std::vector<Problem>& problems) {
  toml::array* const robots = document["robot"].as_array();
  for (std::size_t i = 0; robots && i < robots->size(); ++i) {
    toml::table* const robot = (*robots)[i].as_table();
    const toml::node* const name = robot ? robot->get("name") : nullptr;
    if (!name || !name->is_string()) continue;
    toml::table* const from = find(file, *name->value<std::string_view>());
    if (!from) {
      Problems place(document, "");
      place.add(name->source(), fmt::format("robot.{}.name: found {}, allowed: a robot of {}: {}", i + 1, shown(*name),
                                            path, names_of(known)));
      for (Problem& problem : std::move(place).sorted()) problems.push_back(std::move(problem));
      continue;
    }
    std::vector<std::string> taken;
    for (auto&& [key, value] : *from) {
      if (key == "name" || key == "version" || robot->contains(key)) continue;
      value.visit([&, k = key.str()](auto& concrete) { robot->insert(k, std::move(concrete)); });  // with its place
      taken.emplace_back(key.str());
    }
    for (const std::string& key : taken) from->erase(key);
  }
}

}  // namespace

tl::expected<std::vector<KnownRobot>, std::vector<Problem>> load_known_robots(const std::string& path) {
  return read_file(path).and_then([&](const toml::table& document) { return read_document(document, path); });
}

bool is_file_of_robots(const std::string& path) {
  const auto file = read_file(path);
  return file && file->size() == 1 && file->contains("robot");
}

std::string known_robots_file(const std::string& asked) {
  constexpr const char* name = "robots.toml";
  if (!asked.empty()) return asked;
  if (fs::exists(name)) return name;
  if (const char* const config = std::getenv("XDG_CONFIG_HOME"); config && *config == '/')
    return (fs::path(config) / "skein" / name).string();
  const std::string home = home_folder();
  return home.empty() ? name : (fs::path(home) / ".config/skein" / name).string();
}

bool embed_known_robots(toml::table& document, const std::string& directory, std::vector<Problem>& problems) {
  const toml::node* const key = document.get("robots_file");
  if (!key || !key->is_string()) return false;
  const toml::source_region place = key->source();
  const std::string path = (fs::path(directory) / *key->value<std::string>()).string();
  document.erase("robots_file");
  auto file = read_file(path);
  if (!file && file.error().front().line == 0) {  // said where the file is named
    Problems unreadable(document, "");
    unreadable.add(place, fmt::format("robots_file: {}", file.error().front().message()));
    for (Problem& problem : std::move(unreadable).sorted()) problems.push_back(std::move(problem));
    return true;
  }
  const auto known = file ? read_document(*file, path) : tl::unexpected(file.error());
  if (known)
    merge(document, *file, path, *known, problems);
  else
    problems.insert(problems.end(), known.error().begin(), known.error().end());
  return true;
}

bool is(const KnownRobot& known, const RobotSpec& robot) {
  if (!robot.name.empty()) return known.spec.name == robot.name;
  const auto link = comms::parse_link_address(robot.address);
  return link && known.spec.address == comms::to_text(*link);
}

std::string as_toml(const KnownRobot& robot) {
  const RobotSpec& spec = robot.spec;
  std::string text = fmt::format("[[robot]]\nname = \"{}\"\nlink = \"{}\"\n", spec.name, spec.address);
  if (!spec.adapter.empty()) text += fmt::format("adapter = \"{}\"\n", spec.adapter);
  if (spec.tag >= 0) text += fmt::format("tag = {}\n", spec.tag);
  text += fmt::format("model = \"{}\"\n", spec.type->name);
  if (!robot.version.empty()) text += fmt::format("version = {}\n", toml_string(robot.version));
  return text;
}

Added with_robots(std::string_view text, const std::vector<KnownRobot>& known, const std::vector<KnownRobot>& more) {
  Added added{std::string(text), 0};
  for (const KnownRobot& robot : more) {
    if (std::any_of(known.begin(), known.end(), [&](const KnownRobot& other) {
          return other.spec.address == robot.spec.address || other.spec.name == robot.spec.name;
        }))
      continue;
    if (!added.text.empty() && !added.text.ends_with('\n')) added.text += '\n';
    added.text += (added.text.empty() ? "" : "\n") + as_toml(robot);
    ++added.robots;
  }
  return added;
}

}  // namespace skein::app
