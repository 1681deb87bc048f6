#include "app/experiment/experiment_schema.h"

#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "app/experiment/experiment_keys.h"

namespace skein::app {
namespace {

using Json = nlohmann::ordered_json;

/// Keys with a structure of their own, for which the schema has no more than their names.
struct Structured {
  const char* table;
  std::initializer_list<const char*> keys;
};
const Structured structured[] = {
    {"", {"robots_file", "gain_change", "obstacle", "robot_defaults", "robot", "perturb", "operator"}},
    {"reference",
     {"spacing", "start", "shape", "offsets", "change", "path", "acceleration", "may_meet", "interchangeable"}},
    {"camera", {"also"}},
    {"controller", {"policy", "k_x", "k_theta", "gains", "c_xx", "c_tt", "c_yy", "l_xx", "l_tt", "parameters", "log"}},
};

Json number(const Range& range) {
  Json schema{{"type", "number"}};
  schema[range.above ? "exclusiveMinimum" : "minimum"] = range.low;
  schema["maximum"] = range.high;
  return schema;
}

Json whole(std::int64_t low, std::int64_t high) {
  return {{"type", "integer"}, {"minimum", low}, {"maximum", high}};
}

Json schema_of(const ExperimentKey& key, const Experiment& e) {
  Json schema = std::visit(Overloaded{
                               [&](const one_of<NumberKey, OptionalNumberKey> auto& k) { return number(k.range(e)); },
                               [](const one_of<WholeKey, OptionalWholeKey> auto& k) { return whole(k.low, k.high); },
                               [](const one_of<FlagKey, OptionalFlagKey> auto&) {
                                 return Json{{"type", "boolean"}};
                               },
                               [](const TextKey& k) {
                                 Json text{{"type", "string"}};
                                 if (k.longest > 0) text["minLength"] = k.shortest, text["maxLength"] = k.longest;
                                 return text;
                               },
                               [](const ChoiceKey& k) {
                                 return Json{{"enum", k.words()}};
                               },
                           },
                           key.value);
  const std::string unit = unit_of(key), value = shown_value(key, e);
  schema["description"] = key.help + (unit.empty() ? std::string() : " [" + unit + "]");
  const bool quoted = std::holds_alternative<TextKey>(key.value) || std::holds_alternative<ChoiceKey>(key.value);
  if (quoted)
    schema["default"] = value;
  else if (!value.empty())
    schema["default"] = Json::parse(value);
  return schema;
}

}  // namespace

std::string experiment_schema() {
  const Experiment defaults;
  Json schema{{"$schema", "http://json-schema.org/draft-07/schema#"},
              {"title", "Skein experiment"},
              {"type", "object"},
              {"additionalProperties", false}};
  Json& top = schema["properties"];
  for (const ExperimentKey& key : experiment_keys()) {
    if (!*key.table) {
      top[key.key] = schema_of(key, defaults);
      continue;
    }
    Json& table = top[key.table];
    if (table.is_null()) table = {{"type", "object"}, {"additionalProperties", false}};
    table["properties"][key.key] = schema_of(key, defaults);
  }
  for (const auto& [table, keys] : structured)
    for (const char* const key : keys) (*table ? top[table]["properties"] : top)[key] = Json::object();
  return schema.dump(2) + "\n";
}

}  // namespace skein::app
