#include "app/experiment/toml_places.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/experiment/toml_table.h"

namespace skein::app {

std::string toml_string(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      result += {'\\', c};
    else if (byte < 0x20 || byte == 0x7f)
      result += fmt::format("\\u{:04X}", byte);
    else
      result += c;
  }
  return result + '"';
}

std::optional<toml::table> parsed_toml(std::string_view text) {
  try {
    return parse_bounded(text, {});
  } catch (const toml::parse_error&) {
    return std::nullopt;
  }
}

std::size_t offset_of(std::string_view text, const toml::source_position& place) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < place.line; ++line) at = std::min(text.find('\n', at), text.size() - 1) + 1;
  for (toml::source_index column = 1; column < place.column && at < text.size(); ++column) {
    ++at;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U) ++at;
  }
  return at;
}

std::size_t end_of_table(std::string_view text, const toml::table& table, bool root) {
  toml::source_index last = root ? 0 : table.source().begin.line;
  for (auto&& [key, value] : table)
    if (!value.is_table() && !value.is_array_of_tables()) last = std::max(last, value.source().end.line);
  std::size_t at = 0;
  for (toml::source_index line = 0; line < last && at < text.size(); ++line) {
    const std::size_t end = text.find('\n', at);
    at = end == std::string_view::npos ? text.size() : end + 1;
  }
  return at;
}

}  // namespace skein::app
