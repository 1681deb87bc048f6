#include "app/runs/run_query.h"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include "app/run/utf8.h"

namespace skein::app {
namespace {

using Relation = RunQuery::Relation;
using Result = tl::expected<RunQuery, std::string>;

constexpr std::array<std::pair<std::string_view, Relation>, 7> relations{{
    {"!=", Relation::unequal},  // longer ones first
    {"<=", Relation::at_most},
    {">=", Relation::at_least},
    {"=", Relation::equal},
    {"<", Relation::less},
    {">", Relation::greater},
    {"~", Relation::contains},
}};
constexpr int deepest = 100;  // brackets and nots within one another
constexpr int most = 500;     // comparisons: SQLite takes expressions up to 1,000 deep

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  Result whole() {
    Result result = any();
    skip();
    if (result && at_ < text_.size()) return refuse("and, or, or the end");
    return result;
  }

 private:
  Result any() { return chain(RunQuery::Kind::any, "or", &Parser::all); }
  Result all() { return chain(RunQuery::Kind::all, "and", &Parser::one); }

  Result chain(RunQuery::Kind kind, std::string_view joint, Result (Parser::*part)()) {
    Result first = (this->*part)();
    if (!first || !peek_word(joint)) return first;
    RunQuery list{.kind = kind};
    list.of.push_back(std::move(*first));
    while (take_word(joint)) {
      Result next = (this->*part)();
      if (!next) return next;
      list.of.push_back(std::move(*next));
    }
    return list;
  }

  Result one() {
    struct Depth {
      int& depth;
      ~Depth() { --depth; }
    } const depth{++depth_};
    if (depth_ > deepest) return refuse("fewer brackets within one another");
    if (take_word("not")) {
      Result of = one();
      if (!of) return of;
      RunQuery negation{.kind = RunQuery::Kind::negation};
      negation.of.push_back(std::move(*of));
      return negation;
    }
    if (take("(")) {
      Result inside = any();
      if (inside && !take(")")) return refuse(")");
      return inside;
    }
    return comparison();
  }

  Result comparison() {
    skip();
    std::string key(word());
    if (key.empty()) return refuse("a key, such as k_xx or collisions");
    if (++comparisons_ > most) return refuse(fmt::format("at most {} comparisons", most));
    at_ += key.size();
    for (const auto& [sign, relation] : relations)
      if (take(sign)) {
        auto value = operand();
        if (!value) return tl::unexpected(value.error());
        if (relation == Relation::contains && !std::holds_alternative<std::string>(*value))
          return tl::unexpected(fmt::format("{} ~: found a number, allowed: a text between quotes", key));
        return RunQuery{.comparison = {std::move(key), relation, std::move(*value)}};
      }
    return refuse("= != < <= > >= or ~");
  }

  tl::expected<RunValue, std::string> operand() {
    skip();
    if (at_ < text_.size() && (text_[at_] == '\'' || text_[at_] == '"')) {
      const std::size_t end = text_.find(text_[at_], at_ + 1);
      if (end == std::string_view::npos) return tl::unexpected(refuse("a quote at the end of the text").error());
      std::string inside(text_.substr(at_ + 1, end - at_ - 1));
      at_ = end + 1;
      return inside;
    }
    const std::string_view found = word();
    if (found.empty()) return tl::unexpected(refuse("a number, a word, or a text between quotes").error());
    at_ += found.size();
    if (auto number = number_of(found)) {
      if (const double* const value = std::get_if<double>(&*number); value != nullptr && !std::isfinite(*value))
        return tl::unexpected(
            fmt::format("column {} of the condition: found {}, which no key has, allowed: a finite number",
                        at_ - found.size() + 1, found));
      return *std::move(number);
    }
    return std::string(found);
  }

  /// What stands here up to a blank, a bracket, a quote or a sign of a comparison.
  std::string_view word() const {
    std::size_t end = at_;
    while (end < text_.size() && std::isspace(static_cast<unsigned char>(text_[end])) == 0 &&
           std::string_view("()'\"=!<>~").find(text_[end]) == std::string_view::npos)
      ++end;
    return text_.substr(at_, end - at_);
  }
  bool peek_word(std::string_view expected) {
    skip();
    return word() == expected;
  }
  bool take_word(std::string_view expected) {
    if (!peek_word(expected)) return false;
    at_ += expected.size();
    return true;
  }
  bool take(std::string_view sign) {
    skip();
    if (!text_.substr(at_).starts_with(sign)) return false;
    at_ += sign.size();
    return true;
  }
  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  Result refuse(std::string_view allowed) {
    skip();
    const std::string found =
        at_ < text_.size() ? fmt::format("\"{}\"", first_letters(text_.substr(at_), 20)) : "the end";
    return tl::unexpected(fmt::format("column {} of the condition: found {}, allowed: {}", at_ + 1, found, allowed));
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0, comparisons_ = 0;
};

}  // namespace

Result parse_query(std::string_view text) {
  return Parser(text).whole();
}

}  // namespace skein::app
