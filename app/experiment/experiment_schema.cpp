#include "app/experiment/experiment_schema.h"

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "app/experiment/experiment_keys.h"
#include "core/kinematics/robot_type.h"
#include "core/reference/formation.h"
#include "core/words.h"

namespace skein::app {
namespace {

using Json = nlohmann::ordered_json;

Json number(const Range& range) {
  Json schema{{"type", "number"}};
  schema[range.above ? "exclusiveMinimum" : "minimum"] = range.low;
  schema["maximum"] = range.high;
  return schema;
}

Json whole(std::int64_t low, std::int64_t high) {
  return {{"type", "integer"}, {"minimum", low}, {"maximum", high}};
}

/// What a key allows at some rate: some ranges depend on it, and an editor does not follow that.
Range at_any_rate(Range (*range)(const Experiment&)) {
  const Range rates = std::get<NumberKey>(find_experiment_key("rate")->value).range({});
  Experiment slowest, fastest;
  slowest.rate = rates.low;
  fastest.rate = rates.high;
  Range wide = range(slowest);
  const Range other = range(fastest);
  wide.low = std::min(wide.low, other.low);
  wide.high = std::max(wide.high, other.high);
  return wide;
}

Json schema_of(const ExperimentKey& key, const Experiment& e) {
  Json schema =
      std::visit(Overloaded{
                     [](const one_of<NumberKey, OptionalNumberKey> auto& k) { return number(at_any_rate(k.range)); },
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

Json of_type(const char* type) {
  return {{"type", type}};
}

Json list_of(Json element) {
  return {{"type", "array"}, {"items", std::move(element)}};
}

/// An array of so many numbers.
Json numbers(std::size_t least, std::size_t most) {
  Json array = list_of(of_type("number"));
  array["minItems"] = least;
  array["maxItems"] = most;
  return array;
}

Json any_of(Json one, Json other) {
  return {{"anyOf", Json::array({std::move(one), std::move(other)})}};
}

template <typename Enum>
Json words_of() {
  Json words = Json::array();
  for (const Enum value : core::all_of<Enum>()) words.push_back(word(value));
  return {{"enum", std::move(words)}};
}

using Names = std::initializer_list<const char*>;

/// A table that has no other keys. `needed`: these must be there.
Json table_of(Json keys, Names needed = {}) {
  Json table{{"type", "object"}, {"additionalProperties", false}, {"properties", std::move(keys)}};
  if (needed.size() > 0) table["required"] = needed;
  return table;
}

/// Adds keys of one type.
void add(Json& keys, Names names, const Json& type) {
  for (const char* const name : names) keys[name] = type;
}

// Keys with a structure of their own: types and words. Which of them belong together, and the range of each number, the
// parser says.

/// [[x, y], ...]
Json points() {
  return list_of(numbers(2, 2));
}

Json path() {
  Json keys{{"shape", words_of<PathSpec::Shape>()}, {"points", points()}, {"closed", of_type("boolean")}};
  add(keys, {"from", "to", "centre"}, numbers(2, 2));
  add(keys, {"width", "height", "radius"}, of_type("number"));
  return table_of(std::move(keys));
}

Json trajectory() {
  Json keys{{"path", path()}, {"csv", of_type("string")}, {"samples", list_of(numbers(3, 4))}};
  add(keys, {"t", "start", "speed", "acceleration", "distance", "duration", "turn_rate"}, of_type("number"));
  return table_of(std::move(keys));
}

/// Of [robot_defaults] and of every [[robot]].
Json robot_keys() {
  Json models = Json::array();
  for (const core::RobotType& type : core::robot_types) models.push_back(type.name);
  Json keys{{"model", {{"enum", std::move(models)}}}, {"p", of_type("integer")}};
  add(keys, {"link", "adapter"}, of_type("string"));
  add(keys,
      {"radius", "wheel_diameter", "wheel_ratio", "track", "actuation_delay", "watchdog", "v_max", "omega_max", "c_x",
       "c_theta", "k_x", "k_theta", "alpha", "beta", "K_a", "K_o"},
      of_type("number"));
  return keys;
}

Json robot() {
  Json keys = robot_keys(), truth{{"runaway", numbers(1, 3)}};
  add(truth, {"wheel_diameter", "wheel_ratio", "track", "actuation_delay"}, of_type("number"));
  keys["name"] = of_type("string");
  keys["tag"] = of_type("integer");
  keys["start"] = numbers(3, 3);
  keys["truth"] = table_of(std::move(truth));
  keys["trajectory"] = trajectory();
  return table_of(std::move(keys));
}

/// The formation's shape by name, or the robots' own places.
Json shape_keys() {
  return {{"shape", words_of<core::ShapeName>()}, {"spacing", of_type("number")}, {"offsets", points()}};
}

void add_reference(Json& keys) {
  keys.update(shape_keys());
  add(keys, {"start", "acceleration"}, of_type("number"));
  add(keys, {"may_meet", "interchangeable"}, of_type("boolean"));
  keys["path"] = path();
  Json change = shape_keys();
  add(change, {"t", "duration"}, of_type("number"));
  keys["change"] = list_of(table_of(std::move(change), {"t", "duration"}));
}

/// One number for all pairs, or [[i, j, value], ...].
Json of_pairs() {
  return any_of(of_type("number"), list_of(numbers(3, 3)));
}

void add_controller(Json& keys) {
  keys["policy"] = words_of<core::GainPolicy>();
  Json gains = Json::object();
  for (const core::GainName name : core::all_of<core::GainName>())
    (name <= core::gain_names.back() ? gains : keys)[std::string(word(name))] = of_pairs();
  keys["gains"] = table_of(std::move(gains));
  for (const core::TrackingGain name : core::tracking_names) keys[std::string(word(name))] = of_type("number");
  keys["parameters"] = {{"type", "object"}, {"additionalProperties", of_type("number")}};
  keys["log"] = list_of(of_type("string"));
}

Json gain_change() {
  Json keys = Json::object();
  add(keys, {"t", "ramp"}, of_type("number"));
  for (const core::GainName name : core::all_of<core::GainName>()) keys[std::string(word(name))] = of_pairs();
  for (const core::TrackingGain name : core::tracking_names)  // of one robot: [i, value]
    keys[std::string(word(name))] = any_of(of_type("number"), list_of(numbers(2, 2)));
  return table_of(std::move(keys), {"t"});
}

void add_lists(Json& top) {
  top["robots_file"] = of_type("string");
  top["robot_defaults"] = table_of(robot_keys());
  top["robot"] = list_of(robot());
  top["gain_change"] = list_of(gain_change());
  Json obstacle = Json::object(), moved{{"robot", of_type("integer")}};
  add(obstacle, {"x", "y", "radius"}, of_type("number"));
  top["obstacle"] = list_of(table_of(std::move(obstacle), {"x", "y", "radius"}));
  add(moved, {"t", "dx", "dy", "dtheta"}, of_type("number"));
  top["perturb"] = list_of(table_of(std::move(moved), {"t", "robot"}));
  Json action{{"t", of_type("number")}, {"does", of_type("string")}};
  top["operator"] = list_of(table_of(std::move(action), {"t", "does"}));
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
    if (table.is_null()) table = table_of(Json::object());
    table["properties"][key.key] = schema_of(key, defaults);
  }
  add_reference(top["reference"]["properties"]);
  add_controller(top["controller"]["properties"]);
  const Json camera = top["camera"];
  top["camera"]["properties"]["also"] = list_of(camera);  // with the same keys
  add_lists(top);
  return schema.dump(2) + "\n";
}

}  // namespace skein::app
