#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/cli/command_runs.h"
#include "app/exchange/export.h"

namespace skein::app {

struct ExportRequest {
  std::string run, out;   ///< a CSV, or a kept run; out: empty: beside the CSV
  std::string directory;  ///< of kept runs; empty: runs_directory() says which
  ExportOptions options;
};
/// Converts a run's CSV into a file for other programs.
int export_file(const ExportRequest& request);

struct IdentifyRequest {
  std::vector<std::string> runs;  ///< CSVs, or kept runs
  std::string directory;          ///< of kept runs; empty: runs_directory() says which
  std::string file;               ///< of robots; empty: known_robots_file() says which
  std::string report;             ///< folder for residuals; empty: none
  bool save = false;              ///< into the file of robots
  bool json = false;
};
/// Identifies the robots of runs. See identify.h. `expectation_failed` if the runs do not determine a value.
int identify(const IdentifyRequest& request);

/// --runs-dir of a command.
CLI::Option* add_runs_directory(CLI::App& command, std::string& directory);

/// The options of `skein export` and `skein runs`.
class RunCommands {
 public:
  void add_to(CLI::App& program);
  /// Whether one of these commands was given that may be ended at any time: all but the one that removes, and export,
  /// whose draft is as large as what it writes. After parsing.
  bool may_be_ended() const;
  /// Executes the given command and returns its ExitStatus; none: another command was given.
  std::optional<int> run();

 private:
  void add_export(CLI::App& to);

  CLI::App *export_ = nullptr, *export_kept_ = nullptr;
  CLI::App *report_ = nullptr, *identify_ = nullptr;
  IdentifyRequest identify_request_;
  PageRequest page_request_;
  bool html_ = false;
  CLI::App *list_ = nullptr, *show_ = nullptr, *find_ = nullptr, *compare_ = nullptr, *verify_ = nullptr,
           *remove_ = nullptr;
  RunsRequest runs_request_;
  ExportRequest export_request_;
  std::string format_, compression_ = "zstd";
};

}  // namespace skein::app
