#include "app/experiment/experiment_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "app/experiment/toml_places.h"

namespace skein::app {
namespace {

constexpr std::array arrays_of_tables{"robot", "gain_change", "obstacle", "perturb", "operator"};

/// "a.b=1" is a TOML document of its own; a value that is none is taken as a text.
toml::table parsed(const std::string& set, const std::string& origin) {
  const std::size_t equals = set.find('=');
  const std::string key = set.substr(0, equals), value = set.substr(equals + 1);
  if (value.find('\n') == std::string::npos) {
    try {
      return toml::parse(key + " = " + value, origin);
    } catch (const toml::parse_error&) {
    }
  }
  return toml::parse(key + " = " + toml_string(value), origin);
}

/// Moves everything of `from` into `into`; an error says what cannot be.
std::optional<std::string> merge(toml::table& into, toml::table& from, bool top_level);

/// "2.tag" below an array: element 2, or a new one behind the last.
std::optional<std::string> merge_element(toml::array& into, toml::table& from, const std::string& name) {
  for (auto&& [key, value] : from) {
    std::size_t index = 0;
    const std::string_view text = key.str();
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    toml::table* const element = value.as_table();
    if (error != std::errc{} || stop != text.data() + text.size() || index < 1 || index > into.size() + 1 || !element)
      return fmt::format("{}: found {}, allowed: a number from 1 to {} and a key behind it, as in {}.1.key=value", name,
                         text, into.size() + 1, name);
    if (index == into.size() + 1) {
      into.push_back(std::move(*element));
    } else if (toml::table* const there = into.get(index - 1)->as_table()) {
      if (auto problem = merge(*there, *element, false)) return problem;
    }
  }
  return std::nullopt;
}

std::optional<std::string> merge(toml::table& into, toml::table& from, bool top_level) {
  for (auto&& [key, value] : from) {
    const std::string name(key.str());
    toml::table* const below = value.as_table();
    const bool descend = below && !below->is_inline();
    if (top_level && descend && !into.contains(name) &&
        std::find(arrays_of_tables.begin(), arrays_of_tables.end(), name) != arrays_of_tables.end()) {
      toml::array tables;
      if (name == "robot")  // the four that a file without [[robot]] has
        for (int tag = 1; tag <= 4; ++tag) tables.push_back(toml::table{{"tag", tag}});
      into.insert(name, std::move(tables));
    }
    toml::node* const there = into.get(name);
    std::optional<std::string> problem;
    if (descend && there && there->is_table())
      problem = merge(*there->as_table(), *below, false);
    else if (descend && there && there->is_array())
      problem = merge_element(*there->as_array(), *below, name);
    else
      value.visit([&](auto& concrete) { into.insert_or_assign(name, std::move(concrete)); });
    if (problem) return problem;
  }
  return std::nullopt;
}

}  // namespace

void apply_sets(toml::table& document, const std::vector<std::string>& sets, std::vector<Problem>& problems) {
  for (const std::string& set : sets) {
    const std::string origin = "--set " + set;
    if (set.find('=') == std::string::npos || set.find('\n') < set.find('=')) {
      problems.push_back({origin, 0, 0, "found no =, allowed: key=value"});
      continue;
    }
    try {
      toml::table change = parsed(set, origin);
      if (const std::optional<std::string> problem = merge(document, change, true))
        problems.push_back({origin, 0, 0, *problem});
    } catch (const toml::parse_error& error) {
      problems.push_back({origin, 0, 0, std::string(error.description())});
    }
  }
}

}  // namespace skein::app
