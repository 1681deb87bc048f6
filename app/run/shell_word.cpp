#include "app/run/shell_word.h"

#include <string_view>

namespace skein::app {

std::string shell_word(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string shell_word_if_needed(const std::string& word) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+.,/:=@%";
  const bool needs_none = !word.empty() && word.find_first_not_of(plain) == std::string::npos;
  return needs_none ? word : shell_word(word);
}

}  // namespace skein::app
