#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein::app {

/// The one of `words` that a misspelt word probably stands for; none: none differs in at most a third of its letters.
std::optional<std::string> nearest_word(std::string_view written, const std::vector<std::string>& words);

/// For a message, between what was found and what is allowed: "; did you mean --duration?", or a comma.
std::string did_you_mean(std::string_view written, const std::vector<std::string>& words);

}  // namespace skein::app
