#include "app/experiment/experiment_keys.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/experiment/experiment_schema.h"
#include "tests/files.h"
#include "tests/places.h"

namespace skein::app {
namespace {

/// The rows of the tables of docs/experiment-file.md: "controller.v_max" -> "default | allowed | meaning".
std::map<std::string, std::string> documented() {
  std::istringstream text(test::read_file(test::in_source("docs/experiment-file.md")));
  std::map<std::string, std::string> rows;
  std::string table;
  const std::regex heading("#+ \\[+([a-z_.]+)\\]+.*"), top("## The run.*"), name("`([A-Za-z_]+)`");
  for (std::string line; std::getline(text, line);) {
    std::smatch found;
    if (std::regex_match(line, top)) table.clear();
    if (std::regex_match(line, found, heading)) table = std::string(found[1]) + ".";
    if (!line.starts_with("| `")) continue;
    const std::size_t second = line.find(" | ");
    const std::string keys = line.substr(0, second), rest = line.substr(second);
    for (std::sregex_iterator k(keys.begin(), keys.end(), name), none; k != none; ++k)
      rows.emplace(table + (*k)[1].str(), rest);
  }
  return rows;
}

/// Every number in a text.
std::vector<double> numbers(const std::string& text) {
  std::vector<double> all;
  const std::regex number("-?[0-9]+([.][0-9]+)?(e[0-9]+)?");
  for (std::sregex_iterator k(text.begin(), text.end(), number), none; k != none; ++k)
    all.push_back(std::stod(k->str()));
  return all;
}

bool contains(const std::vector<double>& all, double value) {
  return std::any_of(all.begin(), all.end(), [&](double v) { return std::abs(v - value) <= 1e-9 * std::abs(value); });
}

TEST(ExperimentKeys, AreDocumentedWithTheirDefaultsRangesAndWords) {
  const auto rows = documented();
  const Experiment defaults;
  for (const ExperimentKey& key : experiment_keys()) {
    SCOPED_TRACE(key.name());
    const auto row = rows.find(key.name());
    ASSERT_NE(row, rows.end()) << "not in docs/experiment-file.md";
    const std::string& said = row->second;
    const std::string value = shown_value(key, defaults);
    std::visit(Overloaded{
                   [&](const one_of<NumberKey, OptionalNumberKey> auto& k) {
                     const Range range = k.range(defaults);
                     EXPECT_TRUE(value.empty() || contains(numbers(said), std::stod(value))) << value << said;
                     const bool open = said.find("and more") != std::string::npos ||
                                       said.find("own range") != std::string::npos || range.high == 86400.0 ||
                                       said.find("`rate`") != std::string::npos ||
                                       said.find("ticks") != std::string::npos;
                     EXPECT_TRUE(open || contains(numbers(said), range.high)) << range.text() << said;
                     EXPECT_TRUE(!range.above || said.find("above") != std::string::npos) << said;
                   },
                   [&](const WholeKey&) { EXPECT_TRUE(contains(numbers(said), std::stod(value))) << value << said; },
                   [&](const ChoiceKey& k) {
                     for (const std::string_view word : k.words())
                       EXPECT_NE(said.find(fmt::format("`\"{}\"`", word)), std::string::npos) << word << said;
                   },
                   [&](const FlagKey&) { EXPECT_NE(said.find('`' + value + '`'), std::string::npos) << said; },
                   [](const one_of<OptionalWholeKey, OptionalFlagKey, TextKey> auto&) {},
               },
               key.value);
  }
}

TEST(ExperimentKeys, AreReadWithTheirOwnDefaultAndRefusedOutsideTheirRange) {
  for (const ExperimentKey& key : experiment_keys()) {
    SCOPED_TRACE(key.name());
    if (const auto* const number = std::get_if<NumberKey>(&key.value)) {
      const double above_all = 2.0 * number->range(Experiment{}).high + 1.0;
      const auto refused = parse_experiment("", "e.toml", {fmt::format("{}={}", key.name(), above_all)});
      ASSERT_FALSE(refused);
      EXPECT_NE(refused.error().front().text.find(key.name()), std::string::npos) << refused.error().front().text;
      EXPECT_NE(refused.error().front().text.find(allowed_values(key, Experiment{})), std::string::npos)
          << refused.error().front().text;
    }
    if (const auto* const choice = std::get_if<ChoiceKey>(&key.value)) {
      const auto refused = parse_experiment("", "e.toml", {key.name() + "=nonsense"});
      ASSERT_FALSE(refused);
      for (const std::string_view word : choice->words())
        EXPECT_NE(refused.error().front().text.find(word), std::string::npos) << refused.error().front().text;
    }
  }
  EXPECT_EQ(find_experiment_key("controller.v_max")->name(), "controller.v_max");
  EXPECT_EQ(find_experiment_key("controller.v"), nullptr);
}

TEST(ExperimentSchema, IsTheOneThatComesWithSkein) {
  EXPECT_EQ(test::read_file(test::in_source("resources/experiment.schema.json")), experiment_schema())
      << "write it again: skein check --schema > resources/experiment.schema.json";
}

/// The keys that the parser knows in a table, by its answer to one that it does not know.
std::set<std::string> known_in(const std::string& text, const std::string& table) {
  const auto refused = parse_experiment(text, "e.toml", {});
  if (refused) return {};
  const std::string place = table.empty() ? "" : table + ".", where = table.empty() ? "" : " in " + table;
  const std::string begin = place + "zzz: unknown key, allowed" + where + ": ";
  std::set<std::string> known;
  for (const Problem& problem : refused.error()) {
    if (!problem.text.starts_with(begin)) continue;
    std::istringstream names(problem.text.substr(begin.size()));
    for (std::string name; names >> name;) known.insert(name.substr(0, name.find(',')));
  }
  return known;
}

/// A place of the schema, the parser's name of it, and files that have an unknown key there: together they know all
/// keys of the place.
struct SchemaTable {
  std::string place, name;
  std::vector<std::string> files;
};
void PrintTo(const SchemaTable& table, std::ostream* out) {
  *out << (table.name.empty() ? "the top" : table.name);
}

const std::string independent = "[reference]\nkind = \"independent\"\n";
std::vector<std::string> paths(const std::string& before, const std::string& after) {
  std::vector<std::string> files;
  for (const char* shape : {"rounded_rectangle", "circle", "spline", "polyline", "line"})
    files.push_back(fmt::format("{}{{ shape = \"{}\", zzz = 1 }}{}", before, shape, after));
  return files;
}
const std::vector<SchemaTable> schema_tables{
    {"", "", {"zzz = 1"}},
    {"/reference",
     "reference",
     {"[reference]\nzzz = 1", "[reference]\nkind = \"formation\"\nzzz = 1", independent + "zzz = 1"}},
    {"/reference/properties/path", "reference.path", paths("[reference]\npath = ", "")},
    {"/reference/properties/change/items",
     "reference.change.1",
     {"[[reference.change]]\nzzz = 1", "[reference]\nkind = \"formation\"\n[[reference.change]]\nzzz = 1"}},
    {"/controller", "controller", {"[controller]\nzzz = 1"}},
    {"/controller/properties/gains", "controller.gains", {"[controller.gains]\nzzz = 1"}},
    {"/camera", "camera", {"[camera]\nzzz = 1"}},
    {"/camera/properties/also/items", "camera.also.1", {"[[camera.also]]\nzzz = 1"}},
    {"/robot_defaults", "robot_defaults", {"[robot_defaults]\nzzz = 1"}},
    {"/robot/items", "robot.1", {"[[robot]]\nzzz = 1"}},
    {"/robot/items/properties/truth", "robot.1.truth", {"[[robot]]\ntruth = { zzz = 1 }"}},
    {"/robot/items/properties/trajectory",
     "robot.1.trajectory",
     {independent + "[[robot]]\ntrajectory = { zzz = 1 }",
      independent + "[[robot]]\ntrajectory = { samples = [], zzz = 1 }"}},
    {"/robot/items/properties/trajectory/properties/path", "robot.1.trajectory.path",
     paths(independent + "[[robot]]\ntrajectory = { path = ", " }")},
    {"/gain_change/items",
     "gain_change.1",
     {"[[gain_change]]\nzzz = 1", "[[gain_change]]\nk_x = 1\nk_theta = 1\nzzz = 1"}},
    {"/obstacle/items", "obstacle.1", {"[[obstacle]]\nzzz = 1"}},
    {"/perturb/items", "perturb.1", {"[[perturb]]\nzzz = 1"}},
    {"/operator/items", "operator.1", {"[[operator]]\nzzz = 1"}},
    {"/expect", "expect", {"[expect]\nzzz = 1"}},
};

class SchemaTables : public testing::TestWithParam<SchemaTable> {};
INSTANTIATE_TEST_SUITE_P(Of, SchemaTables, testing::ValuesIn(schema_tables));

TEST_P(SchemaTables, HaveTheKeysThatTheParserReads) {
  const auto& [place, name, files] = GetParam();
  std::set<std::string> read, has;
  for (const std::string& file : files) read.merge(known_in(file, name));
  const auto schema = nlohmann::json::parse(experiment_schema());
  const auto& table = schema.at(nlohmann::json::json_pointer(place.empty() ? "" : "/properties" + place));
  for (const auto& [key, type] : table.at("properties").items()) {
    has.insert(key);
    EXPECT_FALSE(type.empty()) << key << " may be anything";
  }
  EXPECT_EQ(has, read);
  EXPECT_FALSE(table.at("additionalProperties").get<bool>());
}

/// Some ranges depend on the rate: the schema, which does not follow that, refuses nothing that some rate allows.
TEST(ExperimentSchema, AllowsWhatTheFastestRateAllows) {
  const auto schema = nlohmann::json::parse(experiment_schema());
  const double most = schema.at("/properties/shield/properties/gamma/maximum"_json_pointer);
  const std::string set = fmt::format("shield.gamma={}", most);
  EXPECT_TRUE(parse_experiment("", "e.toml", {"rate=1000", set}));
  EXPECT_FALSE(parse_experiment("", "e.toml", {set})) << "the control";
}

TEST(ExperimentSchema, KnowsTheKeys) {
  const auto schema = nlohmann::json::parse(experiment_schema());
  const auto& v_max = schema["properties"]["controller"]["properties"]["v_max"];
  EXPECT_EQ(v_max["type"], "number");
  EXPECT_EQ(v_max["exclusiveMinimum"], 0.0);
  EXPECT_EQ(v_max["maximum"], 10.0);
  EXPECT_EQ(v_max["default"], 0.1);
  EXPECT_EQ(schema["properties"]["controller"]["properties"]["saturation"]["enum"][1], "algebraic");
  EXPECT_FALSE(schema["properties"]["shield"]["additionalProperties"].get<bool>());
}

}  // namespace
}  // namespace skein::app
