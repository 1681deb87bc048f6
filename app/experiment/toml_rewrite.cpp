#include "app/experiment/toml_rewrite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include "app/experiment/toml_places.h"

namespace skein::app {
namespace {

/// A float stays one, and has the fewest digits that read back to it.
std::string written(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char digits[32];
  std::string text(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  const bool whole = text.find_first_of(".e") == std::string::npos;
  return whole ? text + ".0" : text;
}

}  // namespace

std::string toml_key(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  return bare ? std::string(key) : toml_string(key);
}

std::string toml_literal(const toml::node& node) {
  std::string text;
  if (const toml::table* const table = node.as_table()) {
    for (auto&& [key, value] : *table)
      text += fmt::format("{}{} = {}", text.empty() ? " " : ", ", toml_key(key.str()), toml_literal(value));
    return "{" + text + (text.empty() ? "}" : " }");
  }
  if (const toml::array* const array = node.as_array()) {
    for (const toml::node& element : *array) text += (text.empty() ? "" : ", ") + toml_literal(element);
    return "[" + text + "]";
  }
  if (const auto* const value = node.as_floating_point()) return written(value->get());
  if (const auto* const value = node.as_string()) return toml_string(value->get());
  std::ostringstream other;
  node.visit([&](const auto& value) { other << value; });
  return other.str();
}

namespace {

std::string line_of(const toml::key& key, const toml::node& value) {
  return fmt::format("{} = {}\n", toml_key(key.str()), toml_literal(value));
}

/// A table with a header of its own, which the root has not, and those below it, as lines.
void write_table(const toml::table& table, const std::string& name, bool element, std::string& text) {
  if (!name.empty()) text += fmt::format("\n{}{}{}\n", element ? "[[" : "[", name, element ? "]]" : "]");
  const auto has_header = [](const toml::node& node) {
    return (node.is_table() && !node.as_table()->is_inline()) || node.is_array_of_tables();
  };
  for (auto&& [key, value] : table)
    if (!has_header(value)) text += line_of(key, value);
  for (auto&& [key, value] : table) {
    if (!has_header(value)) continue;
    const std::string below = name.empty() ? toml_key(key.str()) : name + '.' + toml_key(key.str());
    if (const toml::array* const array = value.as_array())
      for (const toml::node& one : *array) write_table(*one.as_table(), below, true, text);
    else
      write_table(*value.as_table(), below, false, text);
  }
}

/// The last line of the text that belongs to a node: values below a header stand behind it.
toml::source_index last_line(const toml::node& node) {
  toml::source_index last = node.source().end.line;
  if (const toml::table* const table = node.as_table())
    for (auto&& [key, value] : *table) last = std::max(last, last_line(value));
  if (const toml::array* const array = node.as_array())
    for (const toml::node& element : *array) last = std::max(last, last_line(element));
  return last;
}

bool same_keys(const toml::table& a, const toml::table& b) {
  return a.size() == b.size() &&
         std::all_of(a.begin(), a.end(), [&](auto&& entry) { return b.contains(entry.first.str()); });
}

/// [[name]] in the text, not name = [{...}].
bool has_headers(const toml::node& node) {
  return node.is_array_of_tables() && !node.as_array()->get(0)->as_table()->is_inline();
}

/// The changes that make a text say another document.
class Edits {
 public:
  Edits(std::string_view text, const toml::table& before, const toml::table& after) : text_(text) {
    compare(before, after, "", true);
  }

  std::string apply() && {
    // From the end on, so that places stay what they are; what is put in at one place keeps its order.
    std::stable_sort(edits_.begin(), edits_.end(), [](const Edit& a, const Edit& b) { return a.at < b.at; });
    std::string result(text_);
    for (auto edit = edits_.rbegin(); edit != edits_.rend(); ++edit) result.replace(edit->at, edit->length, edit->text);
    if (!result.empty() && result.back() != '\n') result += '\n';
    return result + end_;
  }

 private:
  struct Edit {
    std::size_t at, length;
    std::string text;
  };

  std::size_t line_begin(std::size_t at) const {
    const std::size_t before = at == 0 ? std::string_view::npos : text_.rfind('\n', at - 1);
    return before == std::string_view::npos ? 0 : before + 1;
  }
  std::size_t line_end(std::size_t at) const {
    const std::size_t end = text_.find('\n', at);
    return end == std::string_view::npos ? text_.size() : end + 1;
  }
  void replace(const toml::node& there, const toml::node& value) {
    const std::size_t begin = offset_of(text_, there.source().begin), end = offset_of(text_, there.source().end);
    edits_.push_back({begin, end - begin, toml_literal(value)});
  }
  /// The lines of a node, from the one where its key or its header is.
  void erase(const toml::source_position& from, const toml::node& there) {
    const std::size_t begin = line_begin(offset_of(text_, from));
    edits_.push_back({begin, line_end(offset_of(text_, {last_line(there), 1})) - begin, ""});
  }
  void erase(const toml::key& key, const toml::node& there) {
    if (!has_headers(there)) return erase(key.source().begin, there);
    for (const toml::node& element : *there.as_array()) erase(element.source().begin, element);
  }

  void compare(const toml::table& before, const toml::table& after, const std::string& name, bool root) {
    for (auto&& [key, value] : before)
      if (!after.contains(key.str())) erase(key, value);
    std::string lines;
    for (auto&& [key, value] : after) {
      const std::string below = name.empty() ? toml_key(key.str()) : name + '.' + toml_key(key.str());
      const toml::node* const there = before.get(key.str());
      const bool becomes_line = there && has_headers(*there) && !value.is_array_of_tables();
      if (becomes_line) erase(before.find(key.str())->first, *there);
      // A header at the end of the text would belong to the last element of the array that is being compared.
      const bool with_header = !becomes_line && !inside_element_;
      if (there && !becomes_line)
        compare(*there, value, below);
      else if (with_header && value.is_table() && !value.as_table()->is_inline())
        write_table(*value.as_table(), below, false, end_);
      else if (with_header && value.is_array_of_tables())
        for (const toml::node& one : *value.as_array()) write_table(*one.as_table(), below, true, end_);
      else
        lines += line_of(key, value);
    }
    if (lines.empty()) return;
    const std::size_t at = end_of_table(text_, before, root);
    const bool line_is_open = at > 0 && text_[at - 1] != '\n';
    edits_.push_back({at, 0, (line_is_open ? "\n" : "") + lines});
  }

  void compare(const toml::node& before, const toml::node& after, const std::string& name) {
    const toml::table *const a = before.as_table(), *const b = after.as_table();
    if (a && b && (!a->is_inline() || same_keys(*a, *b))) return compare(*a, *b, name, false);
    const toml::array *const from = before.as_array(), *const to = after.as_array();
    const bool elements = has_headers(before) ? after.is_array_of_tables() : from && to && from->size() == to->size();
    if (!elements) {
      if (toml_literal(before) != toml_literal(after)) replace(before, after);
      return;
    }
    const bool outside = !std::exchange(inside_element_, true);
    for (std::size_t i = 0; i < std::min(from->size(), to->size()); ++i) compare(*from->get(i), *to->get(i), name);
    if (outside) inside_element_ = false;
    for (std::size_t i = to->size(); i < from->size(); ++i) erase(from->get(i)->source().begin, *from->get(i));
    for (std::size_t i = from->size(); i < to->size(); ++i) write_table(*to->get(i)->as_table(), name, true, end_);
  }

  std::string_view text_;
  std::vector<Edit> edits_;
  std::string end_;  // tables behind all others
  bool inside_element_ = false;
};

}  // namespace

std::string with_document(std::string_view text, const toml::table& document) {
  if (const auto before = parsed_toml(text)) {
    std::string result = Edits(text, *before, document).apply();
    if (const auto again = parsed_toml(result); again && *again == document) return result;
  }
  std::string anew;
  write_table(document, "", false, anew);
  return anew;
}

}  // namespace skein::app
