#pragma once

#include <string>
#include <string_view>

#include <toml++/toml.h>

namespace skein::app {

/// The text of a document, changed only where it says something else than `document`: comments, order and numbers of
/// all other lines stay as they were written. Values that are new are written as short as they can be. Where the text
/// is written in ways that this cannot follow, the whole document is written anew. Reading the result gives `document`.
std::string with_document(std::string_view text, const toml::table& document);

}  // namespace skein::app
