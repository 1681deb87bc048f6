#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace skein::app {

/// A text as a TOML string, quotes included.
std::string toml_string(std::string_view text);

/// What a TOML text says; none: it is no TOML.
std::optional<toml::table> parsed_toml(std::string_view text);

/// Where a place of the parser is in the text: its columns count characters, not bytes.
std::size_t offset_of(std::string_view text, const toml::source_position& place);

/// Where the line after the last value of the root begins, or of a table that has a header of its own.
std::size_t end_of_table(std::string_view text, const toml::table& table, bool root);

}  // namespace skein::app
