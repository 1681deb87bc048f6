#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace skein::app {

struct Utf8Letter {
  std::optional<char32_t> code;  ///< none: the byte is no UTF-8
  std::string_view bytes;
};

/// The first letter of a text that is not empty. Neither half of a pair (UTF-16), nor a code that takes more bytes than
/// it must, is UTF-8.
inline Utf8Letter first_letter(std::string_view text) noexcept {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char head = byte(0);
  const std::size_t size = head < 0x80 ? 1 : head >= 0xf0 ? 4 : head >= 0xe0 ? 3 : 2;
  const Utf8Letter none{{}, text.substr(0, 1)};
  if (size == 1) return {head, text.substr(0, 1)};
  if (head < 0xc2 || head > 0xf4 || text.size() < size) return none;
  char32_t code = head & (0x7fU >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0U) != 0x80U) return none;
    code = code << 6U | (byte(i) & 0x3fU);
  }
  constexpr char32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};  // NOLINT(modernize-avoid-c-arrays)
  if (code < smallest[size] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return none;
  return {code, text.substr(0, size)};
}

/// The letters at the beginning of a text that take at most `most` bytes together.
inline std::string_view first_letters(std::string_view text, std::size_t most) noexcept {
  std::size_t end = 0;
  while (end < text.size()) {
    const std::size_t next = end + first_letter(text.substr(end)).bytes.size();
    if (next > most) break;
    end = next;
  }
  return text.substr(0, end);
}

}  // namespace skein::app
