#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <toml++/toml.h>
#include <tl/expected.hpp>

#include "app/experiment/file_kind.h"
#include "app/experiment/problem.h"
#include "core/words.h"

namespace skein::app {

/// The numbers that a key may have.
struct Range {
  double low;
  double high;
  bool above = false;     ///< low itself is not allowed
  const char* unit = "";  ///< for the message

  bool holds(double value) const noexcept { return (above ? value > low : value >= low) && value <= high; }
  std::string text() const;  ///< "a number above 0 and up to 10 m/s"
};
constexpr Range above(double low, double high, const char* unit = "") {
  return {low, high, true, unit};
}
constexpr Range between(double low, double high, const char* unit = "") {
  return {low, high, false, unit};
}

/// Headings and turns that a file may name: also a full turn that was rounded, such as 6.2832. [rad]
inline constexpr double full_turn = 6.3;

/// toml::parse(), except that a key of very many parts is refused: each part takes the parser's stack. Throws
/// toml::parse_error.
toml::table parse_bounded(std::string_view text, const std::string& file);

/// The document of a TOML text; if it is not TOML, the one problem that stopped the parser, with its place.
tl::expected<toml::table, std::vector<Problem>> parse_toml(std::string_view text, const std::string& file);

/// The same, of a file that is read as one of this kind.
tl::expected<toml::table, std::vector<Problem>> parse_toml(std::string_view text, const std::string& file,
                                                           FileKind read_as);

/// Everything wrong with one document, each with its place.
class Problems {
 public:
  Problems(const toml::table& document, std::string file) : document_(document), file_(std::move(file)) {}

  /// `key` is dotted, elements of arrays counted from 1 ("robot.2.tag"). The place is that of its value, else of the
  /// nearest table around it that is there.
  void add(const std::string& key, const std::string& text);
  void add(const toml::source_region& place, const std::string& text);

  bool has(const std::string& key) const { return find(key).whole; }
  /// Whether the values of these keys are reliable: there is no problem so far with one of them, or with a key above or
  /// below it. Otherwise the reader has a default in its place, which must not be checked.
  bool sound(std::initializer_list<std::string_view> keys) const;
  /// Marks a key whose value is not reliable, for a reason that is reported elsewhere.
  void doubt(std::string key) { doubted_.push_back(std::move(key)); }
  bool empty() const noexcept { return found_.empty(); }
  std::size_t size() const noexcept { return found_.size(); }
  /// In the order of the file; then those of other files, and last those of --set.
  std::vector<Problem> sorted() &&;

 private:
  /// How far a dotted key can be followed.
  struct Way {
    const toml::node* end;
    bool whole;
  };
  Way find(std::string_view key) const;

  const toml::table& document_;
  std::string file_;
  std::vector<Problem> found_;
  std::vector<std::string> doubted_;  // keys that have a problem
};

/// The words of an enumeration for a message: "\"tanh\", \"algebraic\"".
template <typename Enum>
std::string quoted_words() {
  std::string words;
  for (const Enum value : core::all_of<Enum>())
    words += (words.empty() ? "\"" : ", \"") + std::string(word(value)) + '"';
  return words;
}

/// Reads one table, key by key: a key that is there must have the right type and a value in range, a key that is not
/// leaves its target alone. `finish` refuses every key that was not read.
class TomlTable {
 public:
  /// A null table has no keys. `path` is the table's own dotted key, empty for the document.
  TomlTable(const toml::table* table, std::string path, Problems& problems)
      : table_(table), path_(std::move(path)), problems_(&problems) {}

  bool has(std::string_view key) const { return table_ && table_->contains(key); }
  /// Whether the value of this key of the document ("rate") is reliable, see Problems::sound().
  bool sound(std::string_view key) const { return problems_->sound({key}); }
  std::string full(std::string_view key) const;  ///< "controller.v_max"

  /// The key's value, or null where there is none; the key counts as known from now on.
  const toml::node* node(const char* key);
  /// Refuses a value: "controller.v_max: found -1, allowed: ...".
  void refuse(std::string_view key, const toml::node& found, const std::string& allowed);
  /// Refuses the table if the key is not there.
  void require(std::string_view key, const std::string& allowed);

  void number(const char* key, double& target, const Range& range);
  void integer(const char* key, std::int64_t& target, std::int64_t low, std::int64_t high);
  /// The same, and the key must be there.
  void needed(const char* key, double& target, const Range& range);
  /// An array of exactly N numbers, which must be there.
  template <std::size_t N>
  void needed(const char* key, std::array<double, N>& target, const Range& range);
  void flag(const char* key, bool& target);
  void text(const char* key, std::string& target);
  /// A text of `shortest` to `longest` bytes in one line.
  void line(const char* key, std::string& target, std::size_t longest, std::size_t shortest = 1);

  /// Any integer type, and the same into an optional that stays empty where there is no key.
  template <typename Int>
    requires(std::is_integral_v<Int> && !std::is_same_v<Int, bool> && !std::is_same_v<Int, std::int64_t>)
  void integer(const char* key, Int& target, std::int64_t low, std::int64_t high) {
    auto value = static_cast<std::int64_t>(target);
    integer(key, value, low, high);
    target = static_cast<Int>(value);
  }
  void number(const char* key, std::optional<double>& target, const Range& range) {
    optional(key, target, [&](double& value) { number(key, value, range); });
  }
  void integer(const char* key, std::optional<std::int64_t>& target, std::int64_t low, std::int64_t high) {
    optional(key, target, [&](std::int64_t& value) { integer(key, value, low, high); });
  }
  void flag(const char* key, std::optional<bool>& target) {
    optional(key, target, [&](bool& value) { flag(key, value); });
  }

  /// One of the words of an enumeration (core/words.h).
  template <typename Enum>
  void choice(const char* key, Enum& target) {
    const toml::node* const found = node(key);
    if (!found) return;
    if (const auto value = core::from_word<Enum>(found->value_exact<std::string_view>().value_or("")))
      target = *value;
    else
      refuse(key, *found, quoted_words<Enum>());
  }
  /// The same into an optional that stays empty where there is no key, or another word.
  template <typename Enum>
  void choice(const char* key, std::optional<Enum>& target) {
    Enum value{};
    const std::size_t refused = problems_->size();
    choice(key, value);
    if (has(key) && problems_->size() == refused) target = value;
  }

  /// The table below a key, without keys where there is none.
  TomlTable table(const char* key);
  /// The tables of [[key]].
  std::vector<TomlTable> tables(const char* key);

  /// Refuses every key that was not asked for, with the nearest known one and the list of them.
  void finish() const;

 private:
  template <typename T, typename Read>
  void optional(const char* key, std::optional<T>& target, Read&& read) {
    T value{};
    read(value);
    if (has(key)) target = value;
  }

  const toml::table* table_;
  std::string path_;
  Problems* problems_;  // never null
  std::vector<std::string> known_;
};

/// The numbers of an array of exactly N finite numbers; none: it is something else.
template <std::size_t N>
std::optional<std::array<double, N>> numbers_of(const toml::node& node) {
  const toml::array* const array = node.as_array();
  if (!array || array->size() != N) return {};
  std::array<double, N> values{};
  for (std::size_t k = 0; k < N; ++k) {
    const toml::node& element = *array->get(k);
    const auto value = element.is_number() ? element.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) return {};
    values[k] = *value;
  }
  return values;
}

template <std::size_t N>
void TomlTable::needed(const char* key, std::array<double, N>& target, const Range& range) {
  const std::string allowed = std::to_string(N) + " numbers, each " + range.text();
  require(key, allowed);
  const toml::node* const found = node(key);
  if (!found) return;
  const auto values = numbers_of<N>(*found);
  if (values && std::all_of(values->begin(), values->end(), [&](double value) { return range.holds(value); }))
    target = *values;
  else
    refuse(key, *found, allowed);
}

/// A value as a message shows it: numbers and words as written, else "an array", "a table", "a date".
std::string shown(const toml::node& value);

}  // namespace skein::app
