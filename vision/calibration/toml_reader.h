#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <sstream>
#include <string>

namespace skein::vision::detail {

/// What is wrong, and where. Thrown by Reader and caught where the reading began: a reader of a dozen keys is clearest
/// without a test after each.
struct Problem {
  std::string text;
};

struct Range {
  double least;
  double most;
};

/// The values of a TOML file, each with its place in complaints: file:line:column, key, what was found, what is
/// allowed.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  [[noreturn]] void fail(const toml::source_region& where, const std::string& what) const {
    throw Problem{fmt::format("{}:{}:{}: {}", file_, where.begin.line, where.begin.column, what)};
  }

  void only(const toml::table& table, std::string_view of, std::initializer_list<std::string_view> keys) const {
    for (const auto& [key, value] : table) {
      if (std::find(keys.begin(), keys.end(), key.str()) == keys.end()) {
        fail(key.source(), fmt::format("unknown key '{}{}'; allowed: {}", of, key.str(), fmt::join(keys, ", ")));
      }
    }
  }

  const toml::table* table(const toml::table& root, std::string_view key) const {
    const toml::node* node = root.get(key);
    if (node != nullptr && !node->is_table()) fail(node->source(), wrong(key, *node, "a table"));
    return node == nullptr ? nullptr : node->as_table();
  }

  double number(const toml::table& table, std::string_view of, std::string_view key, Range range) const {
    return number(need(table, of, key), fmt::format("{}{}", of, key), range);
  }

  int integer(const toml::table& table, std::string_view of, std::string_view key, Range range) const {
    const toml::node& node = need(table, of, key);
    const std::string allowed = fmt::format("a whole number from {} to {}", range.least, range.most);
    const auto value = node.value_exact<std::int64_t>();
    if (!value || static_cast<double>(*value) < range.least || static_cast<double>(*value) > range.most) {
      fail(node.source(), wrong(fmt::format("{}{}", of, key), node, allowed));
    }
    return static_cast<int>(*value);
  }

  template <std::size_t N>
  std::array<double, N> numbers(const toml::node& node, const std::string& key, Range range) const {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->size() != N) fail(node.source(), wrong(key, node, fmt::format("{} numbers", N)));
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) values[i] = number(*array->get(i), fmt::format("{}[{}]", key, i), range);
    return values;
  }

  const toml::node& need(const toml::table& table, std::string_view of, std::string_view key) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) fail(table.source(), fmt::format("'{}{}' is missing", of, key));
    return *node;
  }

  std::string wrong(std::string_view key, const toml::node& node, std::string_view allowed) const {
    std::ostringstream found;
    if (const toml::array* array = node.as_array()) {
      found << array->size() << (array->size() == 1 ? " element" : " elements");
    } else if (node.is_table()) {
      found << "a table";
    } else {
      node.visit([&](const auto& value) { found << value; });
    }
    return fmt::format("{} = {}; allowed: {}", key, found.str(), allowed);
  }

 private:
  double number(const toml::node& node, const std::string& key, Range range) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value) || *value < range.least || *value > range.most) {
      fail(node.source(), wrong(key, node, fmt::format("a number from {} to {}", range.least, range.most)));
    }
    return *value;
  }

  std::string file_;
};

}  // namespace skein::vision::detail
