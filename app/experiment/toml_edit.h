#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

namespace skein::app {

/// The value of a key of a TOML text, as written there; none: there is no such key, or the text is not TOML. `key` is
/// dotted, elements of arrays counted from 1: "controller.gains.k_xx", "robot.2.tag".
std::optional<std::string> toml_value(std::string_view text, std::string_view key);

/// The same of several keys, which reads the text once.
std::vector<std::optional<std::string>> toml_values(std::string_view text, const std::vector<std::string>& keys);

/// The text with another value for one key; everything else, including comments and order, is unchanged. A new key is
/// put after those of its table, a new table at the end. The error is the reason why that is impossible.
tl::expected<std::string, std::string> with_toml_value(std::string_view text, std::string_view key,
                                                       std::string_view value);

}  // namespace skein::app
