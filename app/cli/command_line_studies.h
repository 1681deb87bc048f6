#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/tools/study.h"

namespace CLI {
class App;
}

namespace skein::app {

/// Bodies of the commands about studies; each returns an ExitStatus and reports errors on stderr.

struct SweepRequest {
  std::string file, csv;
  std::string report;      ///< a folder for figures
  std::string part, into;  ///< the part of the study, and the folder for it
  std::string merge;       ///< the folder of all parts
  std::vector<std::string> sets;
  std::optional<std::int64_t> runs;
  std::optional<std::uint64_t> seed, only;  ///< only: the one run with this seed
  unsigned threads = 0;                     ///< 0: as many as there are cores
  bool quiet = false, json = false;
  bool plan = false;  ///< only print what the study will cost
};
int sweep(const SweepRequest& request);

struct TuneRequest {
  std::string file, csv;
  std::string report;  ///< a folder for the figure and the experiments of the front
  std::string save;    ///< the experiment file with the chosen gains
  std::vector<std::string> sets;
  std::optional<std::int64_t> runs, candidates, held_out;
  std::optional<std::uint64_t> seed;
  unsigned threads = 0;  ///< 0: as many as there are cores
  bool quiet = false;
};
/// Searches for gains. See tune.h. `expectation_failed` if there is no front.
int tune(const TuneRequest& request);

/// Whether a table of results can be written to this path, which may be empty: an hour's work must not end with a file
/// that cannot be written. What is there stays until then; the study and its experiment are no such files.
tl::expected<void, std::string> check_table(const std::string& path, const Study& study);

/// How many threads can work at once: a job scheduler may have given this process fewer cores than the machine has.
unsigned usable_cores();

/// The subcommands about studies of many runs.
class StudyCommands {
 public:
  void add_to(CLI::App& program);
  /// The result of the given subcommand; empty: none was given.
  std::optional<int> run() const;

 private:
  CLI::App *sweep_ = nullptr, *tune_ = nullptr;
  SweepRequest sweep_request_;
  TuneRequest tune_request_;
};

}  // namespace skein::app
