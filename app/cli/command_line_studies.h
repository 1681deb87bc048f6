#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
};
int sweep(const SweepRequest& request);

/// The subcommands about studies of many runs.
class StudyCommands {
 public:
  void add_to(CLI::App& program);
  /// The result of the given subcommand; empty: none was given.
  std::optional<int> run() const;

 private:
  CLI::App* sweep_ = nullptr;
  SweepRequest sweep_request_;
};

}  // namespace skein::app
