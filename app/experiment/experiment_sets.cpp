#include "app/experiment/experiment_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "app/experiment/toml_places.h"
#include "app/experiment/toml_rewrite.h"
#include "app/experiment/toml_table.h"

namespace skein::app {
namespace {

constexpr std::array arrays_of_tables{"robot", "gain_change", "obstacle", "perturb", "operator"};

bool is_array_of_tables_at_top(std::string_view name) {
  return std::find(arrays_of_tables.begin(), arrays_of_tables.end(), name) != arrays_of_tables.end();
}

/// "a.b=1" is a TOML document of its own; a value that is none is taken as a text.
toml::table parsed(const std::string& set, const std::string& origin) {
  const std::size_t equals = set.find('=');
  const std::string key = set.substr(0, equals), value = set.substr(equals + 1);
  if (value.find('\n') == std::string::npos) {
    try {
      return parse_bounded(key + " = " + value, origin);
    } catch (const toml::parse_error&) {
    }
  }
  return parse_bounded(key + " = " + toml_string(value), origin);
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
    if (top_level && descend && !into.contains(name) && is_array_of_tables_at_top(name)) {
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

/// The values of --set between two documents.
class Differences {
 public:
  Differences(const toml::table& before, const toml::table& after) {
    for (auto&& [key, value] : before)
      if (!after.contains(key.str()) && (value.is_table() || value.is_array()))
        add(toml_key(key.str()), value.is_table() ? "{}" : "[]");
    (void)compare(before, after, "");
  }
  std::vector<std::string> sets() && { return std::move(sets_); }

 private:
  void add(const std::string& name, const std::string& value) { sets_.push_back(name + '=' + value); }

  /// Whether everything between them can be set; if not, nothing has been added.
  bool compare(const toml::table& before, const toml::table& after, const std::string& name) {
    for (auto&& [key, value] : before)
      if (!name.empty() && !after.contains(key.str())) return false;
    for (auto&& [key, value] : after) {
      const std::string below = name.empty() ? toml_key(key.str()) : name + '.' + toml_key(key.str());
      compare(before.get(key.str()), value, below);
    }
    return true;
  }

  void compare(const toml::node* before, const toml::node& after, const std::string& name) {
    if (before && toml_literal(*before) == toml_literal(after)) return;
    const std::size_t had = sets_.size();
    const toml::table* const table = after.as_table();
    if (table && !table->empty() && (before ? before->is_table() : !table->is_inline()))
      if (compare(before ? *before->as_table() : toml::table{}, *table, name)) return;
    sets_.resize(had);
    if (after.is_array_of_tables() && compare_elements(before ? before->as_array() : nullptr, *after.as_array(), name))
      return;
    sets_.resize(had);
    add(name, toml_literal(after));
  }

  /// Element by element, where the array has not become shorter.
  bool compare_elements(const toml::array* before, const toml::array& after, const std::string& name) {
    const std::size_t there = before ? before->size() : 0;
    const bool counted_from_nothing = is_array_of_tables_at_top(name) && name != "robot";
    if ((there == 0 && !counted_from_nothing) || after.size() < there) return false;
    for (std::size_t k = 0; k < after.size(); ++k) {
      const std::string element = fmt::format("{}.{}", name, k + 1);
      const toml::table* const from = k < there ? before->get(k)->as_table() : nullptr;
      if (k < there && !from) return false;
      if (from && !compare(*from, *after.get(k)->as_table(), element)) return false;
      if (!from) add(element, toml_literal(*after.get(k)));
    }
    return true;
  }

  std::vector<std::string> sets_;
};

}  // namespace

std::vector<std::string> sets_between(std::string_view before, std::string_view after) {
  const auto from = parsed_toml(before), to = parsed_toml(after);
  return from && to ? Differences(*from, *to).sets() : std::vector<std::string>{};
}

std::string set_of(const OperatorAction& action, std::size_t number) {
  return fmt::format("operator.{}={{ t = {}, does = {} }}", number, action.t, toml_string(describe(action.event)));
}

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
