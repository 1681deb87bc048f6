#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace skein::app {

/// Text on a terminal. Names of files, robots and runs come from anywhere, and may contain what would move the cursor,
/// change colours, reorder the line or end it. Any thread.

/// The text with everything that a terminal would obey, or cannot show, as TOML and JSON write it (\n, \u001b); bytes
/// that are no UTF-8 as \xff. One line.
std::string shown(std::string_view text);

/// The same for several lines: line ends and tabs stay.
std::string shown_lines(std::string_view text);

/// How many columns of a terminal the text takes: none for a combining mark, two for most of CJK and emoji.
std::size_t columns(std::string_view text);

/// Rows of cells, a line each, their columns aligned; two blanks apart.
std::string table(std::vector<std::vector<std::string>> rows);

}  // namespace skein::app
