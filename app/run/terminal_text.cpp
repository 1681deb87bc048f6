#include "app/run/terminal_text.h"

#include <fmt/format.h>
#include <locale.h>  // NOLINT(modernize-deprecated-headers): newlocale is of POSIX
#include <wchar.h>   // NOLINT(modernize-deprecated-headers): so is wcwidth

#include <algorithm>

#include "app/run/utf8.h"

namespace skein::app {
namespace {

/// What a terminal obeys, or what changes the order of a line: not joiners, which several scripts are written with.
bool is_control(char32_t code) {
  const auto within = [&](char32_t first, char32_t last) { return code >= first && code <= last; };
  return code < 0x20 || within(0x7f, 0x9f) || code == 0x61c || code == 0x200b || within(0x200e, 0x200f) ||
         within(0x2028, 0x202e) || within(0x2060, 0x206f) || code == 0xfeff || within(0xfff9, 0xfffb) ||
         within(0xe0000, 0xe007f);
}

std::string escaped(std::string_view text, bool one_line) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const auto [code, bytes] = first_letter(text);
    text.remove_prefix(bytes.size());
    if (!code)
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(bytes[0]));
    else if (!is_control(*code) || (!one_line && (*code == '\n' || *code == '\t')))
      result += bytes;
    else if (*code == '\n' || *code == '\t' || *code == '\r')
      result += *code == '\n' ? "\\n" : *code == '\t' ? "\\t" : "\\r";
    else if (*code > 0xffff)
      result += fmt::format("\\U{:08x}", static_cast<unsigned>(*code));
    else
      result += fmt::format("\\u{:04x}", static_cast<unsigned>(*code));
  }
  return result;
}

/// The C library knows the widths of letters in a locale of UTF-8 only; the program itself runs in "C".
class LettersOfUtf8 {
 public:
  LettersOfUtf8() noexcept : before_(::uselocale(locale())) {}
  LettersOfUtf8(const LettersOfUtf8&) = delete;
  LettersOfUtf8& operator=(const LettersOfUtf8&) = delete;
  ~LettersOfUtf8() { ::uselocale(before_); }

 private:
  static locale_t locale() noexcept {
    static const locale_t utf8 = ::newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr);
    return utf8;
  }
  locale_t before_;
};

}  // namespace

std::string shown(std::string_view text) {
  return escaped(text, true);
}

std::string shown_lines(std::string_view text) {
  return escaped(text, false);
}

std::size_t columns(std::string_view text) {
  const LettersOfUtf8 letters;
  std::size_t result = 0;
  while (!text.empty()) {
    const auto [code, bytes] = first_letter(text);
    text.remove_prefix(bytes.size());
    const int width = ::wcwidth(static_cast<wchar_t>(code.value_or(U'?')));
    result += width < 0 ? 1 : static_cast<std::size_t>(width);
  }
  return result;
}

std::string table(std::vector<std::vector<std::string>> rows) {
  std::vector<std::size_t> widths;
  for (auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], columns(row[i] = shown(row[i])));
  }
  std::string out;
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      out += row[i];
      if (i + 1 < row.size()) out.append(widths[i] - columns(row[i]) + 2, ' ');
    }
    out += '\n';
  }
  return out;
}

}  // namespace skein::app
