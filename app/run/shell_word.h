#pragma once

#include <string>

namespace skein::app {

/// A word as a shell takes it, in single quotes: for commands that are printed to be copied.
std::string shell_word(const std::string& word);
/// The same, without quotes around a word that needs none: letters, digits and _ - + . , / : = @ %.
std::string shell_word_if_needed(const std::string& word);

}  // namespace skein::app
