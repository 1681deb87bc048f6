#include "app/experiment/toml_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <tuple>
#include <utility>

#include "app/run/nearest_word.h"
#include "app/run/terminal_text.h"

namespace skein::app {
namespace {

constexpr std::string_view set_prefix = "--set ";

const toml::node* child(const toml::node& parent, std::string_view key) {
  if (const toml::table* table = parent.as_table()) return table->get(key);
  const toml::array* array = parent.as_array();
  std::size_t index = 0;
  const auto [stop, error] = std::from_chars(key.data(), key.data() + key.size(), index);
  if (!array || error != std::errc{} || stop != key.data() + key.size() || index < 1) return nullptr;
  return array->get(index - 1);
}

}  // namespace

toml::table parse_bounded(std::string_view text, const std::string& file) {
  constexpr int most = 1000;  // dots between signs that no key has, except in quotes
  toml::source_position place{1, 0};
  int dots = 0;
  for (const char c : text) {
    ++place.column;
    if (c == '.' && ++dots > most)
      throw toml::parse_error("found a key of more than 1000 parts, allowed: a key of this file", place);
    if (std::string_view("\n=,#[]{}").find(c) != std::string_view::npos) dots = 0;
    if (c == '\n') ++place.line, place.column = 0;
  }
  return toml::parse(text, file);
}

tl::expected<toml::table, std::vector<Problem>> parse_toml(std::string_view text, const std::string& file) {
  if (text.starts_with("# skein "))
    return tl::unexpected(std::vector<Problem>{
        {file, 1, 1, "found a recorded run (CSV), allowed: a text in TOML; `skein replay` repeats it"}});
  if (text.find('\0') != std::string_view::npos)
    return tl::unexpected(std::vector<Problem>{{file, 0, 0, "found bytes that are no text, allowed: a text in TOML"}});
  try {
    return parse_bounded(text, file);
  } catch (const toml::parse_error& error) {
    const toml::source_position place = error.source().begin;
    return tl::unexpected(std::vector<Problem>{
        {file, static_cast<int>(place.line), static_cast<int>(place.column), std::string(error.description())}});
  }
}

tl::expected<toml::table, std::vector<Problem>> parse_toml(std::string_view text, const std::string& file,
                                                           FileKind read_as) {
  auto document = parse_toml(text, file);
  if (document)
    if (auto other = check_kind(*document, file, read_as)) return tl::unexpected(std::vector{std::move(*other)});
  return document;
}

std::string Problem::message() const {
  return shown(line > 0 ? fmt::format("{}:{}:{}: {}", file, line, column, text) : fmt::format("{}: {}", file, text));
}

std::string messages(const std::vector<Problem>& problems) {
  std::string lines;
  for (const Problem& problem : problems) lines += (lines.empty() ? "" : "\n") + problem.message();
  return lines;
}

std::string Range::text() const {
  const std::string low_text =
      above ? fmt::format("a number above {:.6g} and up to", low) : fmt::format("a number from {:.6g} to", low);
  return fmt::format("{} {:.6g}{}{}", low_text, high, *unit ? " " : "", unit);
}

Problems::Way Problems::find(std::string_view key) const {
  const toml::node* node = &document_;
  while (!key.empty()) {
    const std::size_t dot = std::min(key.find('.'), key.size());
    const toml::node* const next = child(*node, key.substr(0, dot));
    if (!next) return {node, false};
    node = next;
    key.remove_prefix(std::min(dot + 1, key.size()));
  }
  return {node, true};
}

void Problems::add(const std::string& key, const std::string& text) {
  const toml::node* const place = find(key).end;
  add(place == &document_ ? toml::source_region{} : place->source(), key + ": " + text);
}

void Problems::add(const toml::source_region& place, const std::string& text) {
  const std::string& file = place.path ? *place.path : file_;
  const bool from_set = file.starts_with(set_prefix);   // a --set is one line: its text says where
  doubted_.push_back(text.substr(0, text.find(": ")));  // a problem begins with its key
  found_.push_back({file, from_set ? 0 : static_cast<int>(place.begin.line),
                    from_set ? 0 : static_cast<int>(place.begin.column), text});
}

bool Problems::sound(std::initializer_list<std::string_view> keys) const {
  const auto within = [](std::string_view inner, std::string_view outer) {
    return inner.starts_with(outer) && (inner.size() == outer.size() || inner[outer.size()] == '.');
  };
  return std::none_of(keys.begin(), keys.end(), [&](std::string_view key) {
    return std::any_of(doubted_.begin(), doubted_.end(),
                       [&](const std::string& doubted) { return within(doubted, key) || within(key, doubted); });
  });
}

std::vector<Problem> Problems::sorted() && {
  const auto order = [this](const Problem& p) {
    return std::tuple(p.file.starts_with(set_prefix), p.file != file_, p.line, p.column);
  };
  std::stable_sort(found_.begin(), found_.end(),
                   [&](const Problem& a, const Problem& b) { return order(a) < order(b); });
  return std::move(found_);
}

std::string TomlTable::full(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

const toml::node* TomlTable::node(const char* key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  return table_ ? table_->get(key) : nullptr;
}

void TomlTable::refuse(std::string_view key, const toml::node& found, const std::string& allowed) {
  problems_->add(found.source(), fmt::format("{}: found {}, allowed: {}", full(key), shown(found), allowed));
}

void TomlTable::require(std::string_view key, const std::string& allowed) {
  if (!has(key)) problems_->add(full(key), "missing, allowed: " + allowed);
}

void TomlTable::number(const char* key, double& target, const Range& range) {
  const toml::node* const found = node(key);
  if (!found) return;
  const std::optional<double> value = found->is_number() ? found->value<double>() : std::nullopt;
  if (value && range.holds(*value))
    target = *value;
  else
    refuse(key, *found, range.text());
}

void TomlTable::needed(const char* key, double& target, const Range& range) {
  require(key, range.text());
  number(key, target, range);
}

void TomlTable::integer(const char* key, std::int64_t& target, std::int64_t low, std::int64_t high) {
  const toml::node* const found = node(key);
  if (!found) return;
  const std::optional<std::int64_t> value = found->value_exact<std::int64_t>();
  if (value && *value >= low && *value <= high)
    target = *value;
  else
    refuse(key, *found, fmt::format("a whole number from {} to {}", low, high));
}

void TomlTable::flag(const char* key, bool& target) {
  const toml::node* const found = node(key);
  if (!found) return;
  if (const std::optional<bool> value = found->value_exact<bool>())
    target = *value;
  else
    refuse(key, *found, "true or false");
}

void TomlTable::text(const char* key, std::string& target) {
  const toml::node* const found = node(key);
  if (!found) return;
  if (std::optional<std::string> value = found->value_exact<std::string>())
    target = *std::move(value);
  else
    refuse(key, *found, "a text in quotes");
}

void TomlTable::line(const char* key, std::string& target, std::size_t longest, std::size_t shortest) {
  const toml::node* const found = node(key);
  if (!found || !found->is_string()) return text(key, target);
  const std::string value = *found->value<std::string>();
  const auto printable = [](unsigned char c) { return c >= 0x20 && c != 0x7f; };
  const auto begins = [](unsigned char c) { return (c & 0xc0) != 0x80; };  // else it goes on with a character (UTF-8)
  const auto characters = static_cast<std::size_t>(std::count_if(value.begin(), value.end(), begins));
  if (characters >= shortest && characters <= longest && std::all_of(value.begin(), value.end(), printable))
    target = value;
  else
    refuse(key, *found, fmt::format("{} to {} characters in one line", shortest, longest));
}

TomlTable TomlTable::table(const char* key) {
  const toml::node* const found = node(key);
  if (found && !found->is_table()) refuse(key, *found, fmt::format("a table [{}]", full(key)));
  return {found ? found->as_table() : nullptr, full(key), *problems_};
}

std::vector<TomlTable> TomlTable::tables(const char* key) {
  std::vector<TomlTable> result;
  const toml::node* const found = node(key);
  if (!found) return result;
  const std::string allowed = fmt::format("tables [[{}]]", full(key));
  const toml::array* const array = found->as_array();
  if (!array) {
    refuse(key, *found, allowed);
    return result;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::node& element = (*array)[i];
    const std::string path = fmt::format("{}.{}", full(key), i + 1);
    if (element.is_table())
      result.emplace_back(element.as_table(), path, *problems_);
    else
      problems_->add(element.source(), fmt::format("{}: found {}, allowed: {}", path, shown(element), allowed));
  }
  return result;
}

void TomlTable::finish() const {
  if (!table_) return;
  for (const auto& [key, value] : *table_) {
    const std::string_view written = key.str();
    if (std::find(known_.begin(), known_.end(), written) != known_.end()) continue;
    problems_->add(key.source().begin ? key.source() : value.source(),
                   fmt::format("{}: unknown key{} allowed{}: {}", full(written), did_you_mean(written, known_),
                               path_.empty() ? "" : " in " + path_, fmt::join(known_, ", ")));
  }
}

std::string shown(const toml::node& value) {
  if (const toml::array* const array = value.as_array()) {
    constexpr std::size_t longest = 60;
    std::string text;
    for (const toml::node& element : *array) {
      text += (text.empty() ? "" : ", ") + shown(element);
      if (text.size() > longest) return fmt::format("an array of {}", array->size());
    }
    return "[" + text + "]";
  }
  if (value.is_table()) return "a table";
  if (const auto text = value.value_exact<std::string_view>()) {
    constexpr std::size_t longest = 60;
    return text->size() > longest ? fmt::format("\"{}...\"", text->substr(0, longest)) : fmt::format("\"{}\"", *text);
  }
  if (const auto whole = value.value_exact<std::int64_t>()) return fmt::format("{}", *whole);
  if (const auto number = value.value_exact<double>()) return fmt::format("{}", *number);
  if (const auto flag = value.value_exact<bool>()) return *flag ? "true" : "false";
  return "a date or a time";
}

}  // namespace skein::app
