#include "app/runs/run_query.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/run/event.h"
#include "tests/property.h"

namespace skein::app {
namespace {

/// The query with every bracket written out.
std::string shown(const RunQuery& query) {
  const auto list = [](const std::vector<RunQuery>& parts, const char* joint) {
    std::string text;
    for (const RunQuery& part : parts) text += (text.empty() ? "(" : joint) + shown(part);
    return text + ")";
  };
  const RunQuery::Comparison& c = query.comparison;
  const char* const signs[] = {"=", "!=", "<", "<=", ">", ">=", "~"};
  switch (query.kind) {
    case RunQuery::Kind::comparison:
      return c.key + signs[static_cast<int>(c.relation)] +
             std::visit(Overloaded{[](const std::string& words) { return "'" + words + "'"; },
                                   [](const auto& number) { return fmt::format("{}", number); }},
                        c.value);
    case RunQuery::Kind::negation:
      return "not " + shown(query.of.front());
    case RunQuery::Kind::all:
      return list(query.of, " and ");
    case RunQuery::Kind::any:
      return list(query.of, " or ");
  }
  return {};
}
std::string read(const std::string& text) {
  const auto query = parse_query(text);
  return query ? shown(*query) : query.error();
}

TEST(RunQuery, ReadsWhatItSays) {
  EXPECT_EQ(read("k_xx > 0.01 and collisions = 0"), "(k_xx>0.01 and collisions=0)");
  EXPECT_EQ(read("a=1 or b=2 and not c=3"), "(a=1 or (b=2 and not c=3))");
  EXPECT_EQ(read("(a=1 or b=2) and c>=-3e2"), "((a=1 or b=2) and c>=-300)");
  EXPECT_EQ(read("host='lab 2' and name ~ \"pla\""), "(host='lab 2' and name~'pla')");
  EXPECT_EQ(read("began < 2026-11-01"), "began<'2026-11-01'");
  EXPECT_EQ(read("not not (a!=1)"), "not not a!=1");
  EXPECT_EQ(read("seed = 9007199254740993"), "seed=9007199254740993");
}

TEST(RunQuery, NoKeyIsNotANumberOrInfinite) {
  for (const char* const bad : {"k_xx = nan", "k_xx != -nan", "k_xx < inf", "a = 1 and k_xx >= -inf"})
    EXPECT_NE(read(bad).find("allowed: a finite number"), std::string::npos) << bad << ": " << read(bad);
  EXPECT_EQ(read("a = 1 and b = nan").substr(0, 30), "column 15 of the condition: fo");
  EXPECT_EQ(read("name = 'nan'"), "name='nan'");
}

TEST(RunQuery, WhatItCannotReadIsRefusedWithItsPlace) {
  for (const char* const bad : {"", "k_xx", "k_xx >", "> 1", "a=1 b=2", "a=1 and", "(a=1", "a=1)", "a='x", "a ~ 1",
                                "not", "a == 1", "and and and"}) {
    const auto query = parse_query(bad);
    ASSERT_FALSE(query) << bad;
    EXPECT_NE(query.error().find("allowed"), std::string::npos) << bad << ": " << query.error();
  }
  EXPECT_NE(read("a=1 b=2").find("column 5"), std::string::npos);
  EXPECT_FALSE(parse_query(std::string(100'000, '(')));
  std::string long_one = "a=1";
  for (int i = 1; i < 500; ++i) long_one += i % 2 == 0 ? " or a=1" : " and a=1";
  EXPECT_TRUE(parse_query(long_one));
  EXPECT_NE(read(long_one + " or a=1").find("at most 500 comparisons"), std::string::npos);
}

TEST(RunQuery, AnyTextIsReadOrRefused) {
  test::holds("parse_query returns", [] {
    const auto words = *rc::gen::container<std::vector<std::string>>(
        rc::gen::elementOf(std::vector<std::string>{"a", "k_xx", "1", "-2e3", "=", "!=", "<", ">=", "~", "(", ")",
                                                    "and", "or", "not", "'", "'x y'", "\"", " ", "\xff"}));
    std::string text;
    for (const std::string& word : words) text += word + " ";
    const auto query = parse_query(text);
    if (!query)
      RC_ASSERT(!query.error().empty());
    else
      RC_ASSERT(shown(*parse_query(shown(*query))) == shown(*query));
  });
}

}  // namespace
}  // namespace skein::app
