#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace skein::app {

/// The word that was probably meant by one that is none of `words`; none: no word is within a third of its letters.
std::optional<std::string> nearest_word(std::string_view written, const std::vector<std::string>& words);

}  // namespace skein::app
