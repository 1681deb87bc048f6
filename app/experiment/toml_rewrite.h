#pragma once

#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace skein::app {

/// A key as written in TOML, in quotes where necessary.
std::string toml_key(std::string_view key);

/// A value in one line.
std::string toml_literal(const toml::node& value);

/// The text of a document, changed only where it differs from `document`: comments, order and numbers of all other
/// lines stay as they were written. New values are written as short as possible. If the text has a form that this
/// function cannot edit, the whole document is written again. Reading the result gives `document`.
std::string with_document(std::string_view text, const toml::table& document);

}  // namespace skein::app
