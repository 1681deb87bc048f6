#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <tl/expected.hpp>

#include "app/runs/run_query.h"

namespace skein::app {

/// What all kept runs of a directory are known by. The truth is each run's run.json; this is a copy of it in SQLite,
/// DIRECTORY/.index.sqlite, that finds runs quickly and may be thrown away: it is made anew. Where it cannot be
/// written, it is made in memory for the moment. One thread; several programs may use one directory.
class RunIndex {
 public:
  /// Brings the copy up to date with the folders. The error says why the directory cannot be read.
  static tl::expected<RunIndex, std::string> open(const std::string& directory);
  RunIndex(RunIndex&&) noexcept;
  RunIndex& operator=(RunIndex&&) noexcept;
  ~RunIndex();

  using Value = std::variant<double, std::string>;
  struct Run {
    std::string id;  ///< the folder's name
    std::map<std::string, Value> facts;
  };

  /// All runs, the oldest first, with those facts that are asked for.
  std::vector<Run> all(const std::vector<std::string>& keys);
  /// Those for which the query holds. The error names a key that no run has, or that could be several.
  tl::expected<std::vector<Run>, std::string> find(const RunQuery& query, const std::vector<std::string>& keys);
  /// Every fact of a run.
  std::map<std::string, Value> facts(const std::string& id);
  std::vector<std::string> keys();
  std::size_t size();

  /// Folders whose run.json cannot be read, a sentence each.
  const std::vector<std::string>& problems() const noexcept;

 private:
  struct State;
  explicit RunIndex(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace skein::app
