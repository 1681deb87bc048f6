#include "app/experiment/experiment_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/experiment_events.h"
#include "app/experiment/experiment_keys.h"
#include "app/experiment/experiment_reference.h"
#include "app/experiment/experiment_robots.h"
#include "app/experiment/longest.h"
#include "core/controllers/controller_types.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

void read_run(TomlTable& t, Experiment& e) {
  read_keys(t, "", e);
  std::string robots_file;  // embed_known_robots() has put its robots in; what is still there is no text
  t.text("robots_file", robots_file);
}

/// A table of which each key has one value.
void read_table(TomlTable& document, const char* name, Experiment& e) {
  TomlTable t = document.table(name);
  read_keys(t, name, e);
  t.finish();
}

/// One number for all pairs, or [[i, j, value], ...] with 0 for the pairs not listed.
void read_gain(TomlTable& t, const char* key, core::PairTable& gain, const Range& range, Problems& problems) {
  const toml::node* const found = t.node(key);
  if (!found) return;
  if (!found->is_array()) {
    double value = 0.0;
    t.number(key, value, range);
    gain.fill(value);
    return;
  }
  gain.fill(0.0);
  const auto robots = static_cast<std::int64_t>(problems.sound({"robot"}) ? gain.robots() : most_robots);
  core::PairTable listed(gain.robots());
  std::size_t entry = 0;
  for (const toml::node& element : *found->as_array()) {
    const std::string name = fmt::format("{}.{}", t.full(key), ++entry);
    const toml::array* const triple = element.as_array();
    const bool whole = triple && triple->size() == 3;
    const auto i = whole ? (*triple)[0].value_exact<std::int64_t>() : std::nullopt;
    const auto j = whole ? (*triple)[1].value_exact<std::int64_t>() : std::nullopt;
    const auto value = whole && (*triple)[2].is_number() ? (*triple)[2].value<double>() : std::nullopt;
    const auto exists = [&](const std::optional<std::int64_t>& robot) {
      return robot && *robot >= 1 && *robot <= robots;
    };
    if (!exists(i) || !exists(j) || *i == *j || !value || !range.holds(*value)) {
      const std::string parts =
          whole ? fmt::format("[{}, {}, {}]", shown((*triple)[0]), shown((*triple)[1]), shown((*triple)[2]))
                : shown(element);
      problems.add(element.source(),
                   fmt::format("{}: found {}, allowed: [i, j, value] with two different robots from 1 "
                               "to {} and {}",
                               name, parts, robots, range.text()));
      continue;
    }
    const auto a = static_cast<std::size_t>(*i - 1), b = static_cast<std::size_t>(*j - 1);
    if (std::max(a, b) >= gain.robots()) continue;  // how many there are is not known
    if (listed(a, b) != 0.0)
      problems.add(
          element.source(),
          fmt::format("{}: found the pair {}, {} again, allowed: each pair once, since (18c) makes i, j and j, i equal",
                      name, *i, *j));
    listed.set(a, b, 1.0);
    gain.set(a, b, *value);
  }
}

/// A parameter of the couplings: its key, and the numbers that it may have (18b).
struct PairKey {
  core::GainName name;
  const char* key;
  Range range;
};
constexpr PairKey pair_keys[] = {{core::GainName::k_xx, "k_xx", between(0.0, 100.0)},
                                 {core::GainName::k_tt, "k_tt", between(0.0, 100.0)},
                                 {core::GainName::k_yy, "k_yy", between(0.0, 100.0)},
                                 {core::GainName::c_xx, "c_xx", between(0.0, 1e4, "1/m")},
                                 {core::GainName::c_tt, "c_tt", between(0.0, 1e4, "1/rad")},
                                 {core::GainName::c_yy, "c_yy", between(0.0, 1e4, "1/m")},
                                 {core::GainName::l_xx, "l_xx", between(0.0, 1e6, "1/m^2")},
                                 {core::GainName::l_tt, "l_tt", between(0.0, 1e6, "1/rad^2")}};

constexpr const char* only_fixed = "with policy = \"fixed\"; otherwise it is the remainder of (18f, g), as in (36)";

constexpr Range range_of(core::TrackingGain name) {  // (18a)
  switch (name) {
    case core::TrackingGain::k_x:
      return above(0.0, 100.0, "m/s");
    case core::TrackingGain::k_theta:
      break;
  }
  return above(0.0, 100.0, "rad/s");
}

/// One number for all robots, or [[i, value], ...]; robots that are not listed keep theirs.
std::vector<std::optional<double>> read_tracking(TomlTable& t, core::TrackingGain name, std::size_t robots,
                                                 Problems& problems) {
  const std::string key(word(name));
  const Range range = range_of(name);
  const toml::node* const found = t.node(key.c_str());
  if (!found->is_array()) {
    double value = 0.0;
    t.number(key.c_str(), value, range);
    return std::vector<std::optional<double>>(robots, value);
  }
  std::vector<std::optional<double>> values(robots);
  const auto most = static_cast<std::int64_t>(problems.sound({"robot"}) ? robots : most_robots);
  std::size_t entry = 0;
  for (const toml::node& element : *found->as_array()) {
    const std::string place = fmt::format("{}.{}", t.full(key.c_str()), ++entry);
    const toml::array* const pair = element.as_array();
    const bool whole = pair && pair->size() == 2;
    const auto robot = whole ? (*pair)[0].value_exact<std::int64_t>() : std::nullopt;
    const auto value = whole && (*pair)[1].is_number() ? (*pair)[1].value<double>() : std::nullopt;
    if (!robot || *robot < 1 || *robot > most || !value || !range.holds(*value)) {
      problems.add(element.source(),
                   fmt::format("{}: found {}, allowed: [i, value] with a robot from 1 to {} and {}", place,
                               whole ? fmt::format("[{}, {}]", shown((*pair)[0]), shown((*pair)[1])) : shown(element),
                               most, range.text()));
      continue;
    }
    const auto i = static_cast<std::size_t>(*robot - 1);
    if (i >= robots) continue;  // how many there are is not known
    if (values[i])
      problems.add(element.source(), fmt::format("{}: found robot {} again, allowed: each robot once", place, *robot));
    values[i] = *value;
  }
  return values;
}

/// The tracking gains, where they are not what (18f, g) leaves.
void read_policy(TomlTable& t, const Experiment& e, ControllerSpec& c, Problems& problems) {
  t.choice("policy", c.policy);
  const bool known = t.sound("controller.policy");
  const bool fixed = c.policy == core::GainPolicy::fixed;
  for (const auto& [name, target] :
       {std::pair{core::TrackingGain::k_x, &c.k_x}, std::pair{core::TrackingGain::k_theta, &c.k_theta}}) {
    const char* const key = word(name).data();
    if (fixed && known) t.require(key, "the tracking gain, above 0 and at most what (18f, g) leave");
    if (!fixed && known && t.has(key)) t.refuse(key, *t.node(key), only_fixed);
    t.number(key, *target, range_of(name));
  }
  for (std::size_t i = 0; !fixed && known && i < e.robots.size(); ++i) {
    for (const core::TrackingGain name : core::tracking_names)
      if (const auto& own = e.robots[i].own(name))
        problems.add(fmt::format("robot.{}.{}", i + 1, word(name)),
                     fmt::format("found {}, allowed: {}", *own, only_fixed));
  }
}

constexpr std::size_t most_logs = 16;  // as in the memory that is shared

/// [controller.parameters]: what the kind declares, or anything for a controller of the user's own, which says itself
/// what it takes when it is started.
void read_parameters(TomlTable& t, LawSpec& law, Problems& problems) {
  const auto& declared = core::controller_type(law.kind).parameters;
  law.parameters.clear();
  for (const core::ControllerParameter& p : declared) law.parameters.push_back(p.value);
  if (!law.own()) {
    TomlTable parameters = t.table("parameters");
    for (std::size_t k = 0; k < declared.size(); ++k)
      parameters.number(declared[k].name.data(), law.parameters[k],
                        between(declared[k].low, declared[k].high, declared[k].unit.data()));
    parameters.finish();
    return;
  }
  const toml::node* const found = t.node("parameters");
  if (!found) return;
  const toml::table* const table = found->as_table();
  if (!table) return t.refuse("parameters", *found, "a table of numbers");
  for (const auto& [key, value] : *table) {
    const std::string name = "parameters." + std::string(key.str());
    const auto number = value.is_number() ? value.value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number) || !is_plain_name(key.str()) || law.own_parameters.size() >= most_parameters)
      problems.add(value.source(), fmt::format("{}: found {}, allowed: up to {} finite numbers with names of letters, "
                                               "digits and underscores, {} at most",
                                               t.full(name), shown(value), most_parameters, longest_name));
    else
      law.own_parameters.emplace_back(key.str(), *number);
  }
}

void read_log(TomlTable& t, LawSpec& law) {
  const toml::node* const found = t.node("log");
  if (!found) return;
  const toml::array* const names = found->as_array();
  bool good = law.own() && names && names->size() <= most_logs;
  for (std::size_t k = 0; good && k < names->size(); ++k) {
    const std::string name = (*names)[k].value_exact<std::string>().value_or("");
    good = is_plain_name(name) && std::find(law.log.begin(), law.log.end(), name) == law.log.end();
    law.log.push_back(name);
  }
  if (good) return;
  law.log.clear();
  t.refuse("log", *found,
           fmt::format("with controller.command or controller.library, up to {} different names of what it logs, in "
                       "letters, digits and underscores, {} at most",
                       most_logs, longest_name));
}

void read_law(TomlTable& t, LawSpec& law, Problems& problems) {
  if (!problems.sound({"controller.kind", "controller.command", "controller.library"})) {
    for (const char* key : {"parameters", "log"}) t.node(key);  // nothing can be said of them
    return;
  }
  if (!law.command.empty() && !law.library.empty())
    t.refuse("library", *t.node("library"), "one of controller.command and controller.library");
  for (const char* const key : {"failure", "deadline", "memory", "processes", "preview"})
    if (t.has(key) && !law.own()) t.refuse(key, *t.node(key), "with controller.command or controller.library");
  read_parameters(t, law, problems);
  read_log(t, law);
}

void read_controller(TomlTable t, Experiment& e, Problems& problems) {
  ControllerSpec& c = e.controller;
  read_keys(t, "controller", e);
  read_law(t, c.law, problems);
  read_policy(t, e, c, problems);
  TomlTable gains = t.table("gains");
  for (const auto& [name, key, range] : pair_keys)
    read_gain(name <= core::gain_names.back() ? gains : t, key, core::table(c.gains, name), range, problems);
  gains.finish();
  t.finish();
}

void read_gain_changes(TomlTable& document, Experiment& e, Problems& problems) {
  for (TomlTable& t : document.tables("gain_change")) {
    GainChange change;
    t.require("t", "the time in s at which the gains begin to move");
    t.number("t", change.t, between(0.0, longest_run, "s"));
    t.number("ramp", change.ramp, above(0.0, longest_run, "s"));  // Theorem 1 wants gains that are continuous
    bool any = false;
    for (const auto& [name, key, range] : pair_keys) {
      core::PairTable value(e.robots.size());
      read_gain(t, key, value, range, problems);
      if (t.has(key)) change[name] = value, any = true;
    }
    for (const core::TrackingGain name : core::tracking_names) {
      const char* const key = word(name).data();
      if (!t.has(key)) continue;
      any = true;
      change.tracking[name] = read_tracking(t, name, e.robots.size(), problems);
      if (e.controller.policy != core::GainPolicy::fixed && problems.sound({"controller.policy"}))
        t.refuse(key, *t.node(key), only_fixed);
    }
    if (!any) t.require("k_xx", "at least one of k_xx, k_tt, k_yy, c_xx, c_tt, c_yy, l_xx, l_tt, k_x, k_theta");
    t.finish();
    e.gain_changes.push_back(std::move(change));
  }
}

void read_obstacles(TomlTable& document, Experiment& e) {
  for (TomlTable& t : document.tables("obstacle")) {
    core::Obstacle obstacle;
    for (const char* key : {"x", "y", "radius"}) t.require(key, "its place and size in m");
    t.number("x", obstacle.x, between(-0.5 * e.arena_width, 0.5 * e.arena_width, "m"));
    t.number("y", obstacle.y, between(-0.5 * e.arena_height, 0.5 * e.arena_height, "m"));
    t.number("radius", obstacle.radius, above(0.0, longest_length, "m"));
    t.finish();
    e.obstacles.push_back(obstacle);
  }
}

/// `name`: of its table.
void check_camera(const CameraSpec& camera, const std::string& name, Problems& problems) {
  if (!problems.sound({name + ".source"})) return;
  if (!camera_kind(camera.source))
    problems.add(name + ".source",
                 fmt::format(R"(found "{}", allowed: "none", "synthetic", {})", camera.source, vision::source_forms()));
  const auto address = vision::parse_source(camera.source);
  if (!problems.sound({name + ".source"})) return;
  if (!camera.trigger.empty() && !(address && address->kind->triggers))
    problems.add(
        name + ".trigger",
        fmt::format("found \"{}\", allowed: \"\", since only cameras of the kind aravis:CAMERA can be triggered",
                    camera.trigger));
}

/// [camera], and [[camera.also]] with the same keys.
void read_cameras(TomlTable& document, Experiment& e, Problems& problems) {
  TomlTable first = document.table("camera");
  read_keys(first, "camera", e);
  check_camera(e.camera, "camera", problems);
  for (TomlTable& table : first.tables("also")) {
    Experiment other;
    read_keys(table, "camera", other);
    table.finish();
    e.camera.also.push_back(other.camera);
    const std::string name = fmt::format("camera.also.{}", e.camera.also.size());
    check_camera(other.camera, name, problems);
    const auto rendered = [](const CameraSpec& camera) { return camera.kind() == CameraKind::synthetic; };
    if (!problems.sound({name + ".source", "camera.source"})) continue;
    if (other.camera.source == "none" || e.camera.source == "none" || rendered(other.camera) != rendered(e.camera))
      problems.add(name + ".source",
                   fmt::format("found \"{}\" beside camera.source = \"{}\", allowed: \"synthetic\" for all cameras, or "
                               "{} for each",
                               other.camera.source, e.camera.source, vision::source_forms()));
  }
  if (e.cameras() > most_cameras)
    problems.add("camera.also", fmt::format("found {} cameras, allowed: at most {}", e.cameras(), most_cameras));
  first.finish();
}

}  // namespace

core::CouplingGains paper_couplings(std::size_t robots) {
  constexpr std::size_t most = 6;  // whose sums leave k_x a tenth of v_max at the default speed
  core::Gains paper = core::paper_gains(robots);
  if (robots > most)
    for (core::PairTable* const k : {&paper.k_xx, &paper.k_tt, &paper.k_yy})
      k->fill(k->largest() * static_cast<double>(most - 1) / static_cast<double>(robots - 1));
  return {paper.k_xx, paper.k_tt, paper.k_yy, paper.c_xx, paper.c_tt, paper.c_yy, paper.l_xx, paper.l_tt};
}

void read_tables(const toml::table& document, Experiment& e, Problems& problems) {
  TomlTable t(&document, "", problems);
  read_run(t, e);
  read_table(t, "arena", e);
  if (!problems.sound({"arena"})) e.arena_width = e.arena_height = longest_length;  // places may be anywhere
  read_robots(t, e, problems);  // before everything that is said of robots
  read_reference(t.table("reference"), e, problems);
  e.controller.gains = paper_couplings(e.robots.size());
  read_controller(t.table("controller"), e, problems);
  read_gain_changes(t, e, problems);
  read_table(t, "avoidance", e);
  read_table(t, "shield", e);
  read_obstacles(t, e);
  exchange_places(e, problems);
  read_cameras(t, e, problems);
  read_table(t, "tags", e);
  read_table(t, "links", e);
  read_table(t, "failure", e);
  read_table(t, "simulation", e);
  read_table(t, "estimation", e);
  read_table(t, "staging", e);
  read_events(t, e);
  read_table(t, "expect", e);
  t.finish();
}

}  // namespace skein::app
