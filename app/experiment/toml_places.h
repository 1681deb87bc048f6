#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace skein::app {

/// A text as a TOML string, quotes included.
std::string toml_string(std::string_view text);

/// A TOML text as a table; none: it is not TOML.
std::optional<toml::table> parsed_toml(std::string_view text);

/// The byte offset of a place of the parser, whose columns count characters.
std::size_t offset_of(std::string_view text, const toml::source_position& place);

/// The offset of the line after the last value of a table that has a header of its own, or of the root.
std::size_t end_of_table(std::string_view text, const toml::table& table, bool root);

}  // namespace skein::app
