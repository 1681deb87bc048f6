#include "app/experiment/toml_edit.h"

#include <fmt/format.h>

#include <charconv>
#include <vector>

#include "app/experiment/toml_places.h"

namespace skein::app {
namespace {

std::vector<std::string> parts_of(std::string_view key) {
  std::vector<std::string> parts;
  for (;;) {
    const std::size_t dot = key.find('.');
    parts.emplace_back(key.substr(0, dot));
    if (dot == std::string_view::npos) return parts;
    key.remove_prefix(dot + 1);
  }
}

/// What is called so in a table, or which element of an array it is, counted from 1; null: there is none.
const toml::node* child(const toml::node& within, const std::string& part) {
  if (const toml::table* const table = within.as_table()) return table->get(part);
  const toml::array* const array = within.as_array();
  std::size_t index = 0;
  const auto [stop, error] = std::from_chars(part.data(), part.data() + part.size(), index);
  const bool number = error == std::errc{} && stop == part.data() + part.size() && index > 0;
  return array && number ? array->get(index - 1) : nullptr;
}

/// The node of a key, null where there is none.
const toml::node* find(const toml::table& table, const std::vector<std::string>& parts) {
  const toml::node* node = &table;
  for (const std::string& part : parts)
    if (node) node = child(*node, part);
  return node;
}

std::string inserted(std::string_view text, std::size_t at, const std::string& line) {
  std::string result(text.substr(0, at));
  if (!result.empty() && result.back() != '\n') result += '\n';
  return result + line + std::string(text.substr(at));
}

}  // namespace

std::optional<std::string> toml_value(std::string_view text, std::string_view key) {
  return toml_values(text, {std::string(key)}).front();
}

std::vector<std::optional<std::string>> toml_values(std::string_view text, const std::vector<std::string>& keys) {
  const auto table = parsed_toml(text);
  std::vector<std::optional<std::string>> values;
  values.reserve(keys.size());
  for (const std::string& key : keys) {
    const toml::node* const node = table ? find(*table, parts_of(key)) : nullptr;
    if (!node || node->is_table()) {
      values.emplace_back();
      continue;
    }
    const std::size_t begin = offset_of(text, node->source().begin);
    values.emplace_back(text.substr(begin, offset_of(text, node->source().end) - begin));
  }
  return values;
}

tl::expected<std::string, std::string> with_toml_value(std::string_view text, std::string_view key,
                                                       std::string_view value) {
  const auto table = parsed_toml(text);
  if (!table) return tl::unexpected(std::string("the text is not valid TOML yet: correct it first"));
  std::vector<std::string> parts = parts_of(key);
  std::string result;
  if (const toml::node* const there = find(*table, parts)) {
    const std::size_t begin = offset_of(text, there->source().begin), end = offset_of(text, there->source().end);
    result = std::string(text.substr(0, begin)) + std::string(value) + std::string(text.substr(end));
  } else {
    const std::string name = parts.back();
    parts.pop_back();
    const std::string line = fmt::format("{} = {}\n", name, value);
    const toml::node* const within = find(*table, parts);
    const bool has_header = within && within->as_table() && !within->as_table()->is_inline();
    if (parts.empty())
      result = inserted(text, end_of_table(text, *table, true), line);
    else if (has_header)
      result = inserted(text, end_of_table(text, *within->as_table(), false), line);
    else
      result = inserted(text, text.size(), fmt::format("\n[{}]\n{}", fmt::join(parts, "."), line));
  }
  // A table may be written in ways that this does not know: then it says so rather than write something else.
  if (toml_value(result, key) != std::string(value))
    return tl::unexpected(fmt::format("{} cannot be set to {} from here: write it into the text", key, value));
  return result;
}

}  // namespace skein::app
