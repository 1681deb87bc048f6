#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <tl/expected.hpp>

#include "app/runs/run_folder.h"
#include "app/runs/run_query.h"

namespace skein::app {

/// What is wrong with the index of a directory; none: it is sound, or not there. Changes nothing.
std::optional<std::string> damage_of_index(const std::string& directory);

/// The index of all kept runs of a directory: a copy of each run's run.json in SQLite, DIRECTORY/.index.sqlite, for
/// fast searches. It may be deleted: it is rebuilt. If it cannot be written, it is copied to memory and updated there.
/// One thread; several programs may use one directory.
class RunIndex {
 public:
  /// Updates the index from the folders. The error says why the directory cannot be read. `patience`: how long to wait
  /// for another program that is writing the index.
  static tl::expected<RunIndex, std::string> open(const std::string& directory,
                                                  std::chrono::milliseconds patience = std::chrono::seconds(10));
  RunIndex(RunIndex&&) noexcept;
  RunIndex& operator=(RunIndex&&) noexcept;
  ~RunIndex();

  using Value = RunValue;
  struct Run {
    std::string id;  ///< the folder's name
    std::map<std::string, Value> facts;
  };

  /// All runs, the oldest first, with the requested facts.
  std::vector<Run> all(const std::vector<std::string>& keys);
  /// The runs that match the query. The error names an unknown or ambiguous key.
  tl::expected<std::vector<Run>, std::string> find(const RunQuery& query, const std::vector<std::string>& keys);
  /// Every fact of a run.
  std::map<std::string, Value> facts(const std::string& id);
  std::vector<std::string> keys();
  /// Whether each of these words stands for a key; the error names the first that does not. Without runs, all do.
  tl::expected<void, std::string> knows(const std::vector<std::string>& words);
  /// The folder of the run that began last; empty: there is none.
  std::string newest();
  std::size_t size();

  /// Folders whose run.json cannot be read, a sentence each.
  const std::vector<std::string>& problems() const noexcept;

 private:
  struct State;
  explicit RunIndex(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace skein::app
