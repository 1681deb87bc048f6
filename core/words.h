#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

/// The words of an enumeration. Each enumeration with words has a function
///
///     constexpr std::string_view word(Enum value) noexcept;
///
/// an exhaustive switch without a default that returns each enumerator's word (which may be ""), and `{}` for any other
/// value. The enumerators count from 0. This switch is the enumeration's one table: a new enumerator does not compile
/// until it has its word, and printers, parsers, messages and editors all take the words from here.
namespace skein::core {

/// Whether the enumeration has an enumerator of this value.
template <typename Enum>
constexpr bool is_enumerator(Enum value) noexcept {
  return word(value).data() != nullptr;
}

/// All enumerators, in their order.
template <typename Enum>
constexpr auto all_of() noexcept {
  constexpr std::size_t count = [] {
    std::size_t n = 0;
    while (is_enumerator(static_cast<Enum>(n))) ++n;
    return n;
  }();
  std::array<Enum, count> all{};
  for (std::size_t k = 0; k < count; ++k) all[k] = static_cast<Enum>(k);
  return all;
}

/// The same for an enumeration of bits: 1, 2, 4 ...
template <typename Enum>
constexpr auto all_bits_of() noexcept {
  constexpr std::size_t count = [] {
    std::size_t n = 0;
    while (n < 8 * sizeof(Enum) && is_enumerator(static_cast<Enum>(1u << n))) ++n;
    return n;
  }();
  std::array<Enum, count> all{};
  for (std::size_t k = 0; k < count; ++k) all[k] = static_cast<Enum>(1u << k);
  return all;
}

/// The enumerator with this word; none: it is not a word of the enumeration.
template <typename Enum>
constexpr std::optional<Enum> from_word(std::string_view text) noexcept {
  for (const Enum value : all_of<Enum>())
    if (word(value) == text) return value;
  return std::nullopt;
}

}  // namespace skein::core
