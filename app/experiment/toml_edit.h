#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// The value of a key of a TOML text, as it is written there; none: the key is not there, or the text is no TOML.
/// `key` is dotted, elements of arrays counted from 1: "controller.gains.k_xx", "robot.2.tag".
std::optional<std::string> toml_value(std::string_view text, std::string_view key);

/// The text with another value for one key, everything else, comments and order included, as it was. A key that was not
/// there is put behind those of its table, a table that was not there at the end. The error says why that cannot be.
tl::expected<std::string, std::string> with_toml_value(std::string_view text, std::string_view key,
                                                       std::string_view value);

}  // namespace skein::app
