#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/runs/run_folder.h"

namespace skein::app {

/// A query of `skein runs find`, such as
///
///     k_xx > 0.01 and collisions = 0 and not (host = "lab2" or began < 2026-11-01)
///
/// A comparison is a key, one of = != < <= > >= ~ (contains), and a number, a word or a text between quotes. A run
/// without the key does not match, whatever the comparison. `not` binds closest, then `and`, then `or`.
struct RunQuery {
  enum class Relation { equal, unequal, less, at_most, greater, at_least, contains };
  struct Comparison {
    std::string key;
    Relation relation = Relation::equal;
    RunValue value;
  };
  enum class Kind { comparison, negation, all, any };
  Kind kind = Kind::comparison;
  Comparison comparison{};     ///< if it is one
  std::vector<RunQuery> of{};  ///< else: one for a negation, two or more for `and` and `or`
};

/// The error names the column, from 1, what was found there, and what is allowed.
tl::expected<RunQuery, std::string> parse_query(std::string_view text);

}  // namespace skein::app
