#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace skein::app {

inline constexpr std::size_t most_parameters = 64;  ///< of a law
inline constexpr std::size_t longest_name = 31;     ///< of a law's parameters and logged values [bytes]

/// Whether a name can stand in a CSV's header and in any language: letters, digits, underscores.
constexpr bool is_plain_name(std::string_view text) noexcept {
  const auto good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !text.empty() && text.size() <= longest_name && std::all_of(text.begin(), text.end(), good);
}

/// The name of a law's parameter, copied with its event without allocating.
class ParameterName {
 public:
  constexpr ParameterName() noexcept = default;
  /// Of a plain name; anything else is cut off at the longest.
  constexpr explicit ParameterName(std::string_view name) noexcept {
    std::copy_n(name.begin(), std::min(name.size(), longest_name), text_.begin());
  }
  constexpr std::string_view text() const noexcept { return text_.data(); }
  friend constexpr bool operator==(const ParameterName&, const ParameterName&) noexcept = default;

 private:
  std::array<char, longest_name + 1> text_{};
};

}  // namespace skein::app
