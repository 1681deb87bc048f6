#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/experiment/toml_table.h"

namespace skein::app {

/// The kinds of values that a key of an experiment file can have. `at` returns the value's place in the experiment; the
/// allowed range may depend on keys read before.
struct NumberKey {
  double& (*at)(Experiment&);
  Range (*range)(const Experiment&);
};
struct OptionalNumberKey {  ///< empty if the file does not set it
  std::optional<double>& (*at)(Experiment&);
  Range (*range)(const Experiment&);
};
struct WholeKey {
  std::int64_t (*get)(const Experiment&);
  void (*set)(Experiment&, std::int64_t);
  std::int64_t low, high;
};
struct OptionalWholeKey {
  std::optional<std::int64_t>& (*at)(Experiment&);
  std::int64_t low, high;
};
struct FlagKey {
  bool& (*at)(Experiment&);
};
struct OptionalFlagKey {
  std::optional<bool>& (*at)(Experiment&);
};
struct TextKey {
  std::string& (*at)(Experiment&);
  std::size_t longest;       ///< one line of at most this many bytes; 0: any text
  std::size_t shortest = 1;  ///< of such a line; 0: it may be empty
};
struct ChoiceKey {  ///< a word of an enumeration
  void (*read)(TomlTable& table, const char* key, Experiment&);
  std::string_view (*get)(const Experiment&);
  std::vector<std::string_view> (*words)();
};

/// A key of an experiment file that has one value: the parser, its messages, the editor's form, the JSON schema and the
/// test of docs/experiment-file.md all take it from here. Structured values (paths, gains of pairs, robots, lists of
/// tables) are read by separate functions.
struct ExperimentKey {
  const char* table;  ///< "controller"; empty: the top of the file
  const char* key;
  const char* help;  ///< one line
  std::variant<NumberKey, OptionalNumberKey, WholeKey, OptionalWholeKey, FlagKey, OptionalFlagKey, TextKey, ChoiceKey>
      value;

  std::string name() const;  ///< dotted, as for --set: "controller.v_max"
};

/// All of them, table by table, in the order in which they are read.
std::span<const ExperimentKey> experiment_keys();

/// The one with this dotted name; null: there is none.
const ExperimentKey* find_experiment_key(std::string_view name);

/// Reads all keys of one table; the caller reads the rest of the table and calls `finish`.
void read_keys(TomlTable& t, std::string_view table, Experiment& e);

/// An experiment's value, as it is written in a file; empty: it has none.
std::string shown_value(const ExperimentKey& key, const Experiment& e);

/// The allowed values in words: "a number above 0 and up to 10 m/s", "true or false".
std::string allowed_values(const ExperimentKey& key, const Experiment& e);

/// The unit of a number: "m/s"; empty: it has none.
std::string unit_of(const ExperimentKey& key);

}  // namespace skein::app
