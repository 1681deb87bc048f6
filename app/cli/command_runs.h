#pragma once

#include <string>
#include <vector>

namespace skein::app {

/// The options common to all `skein runs` commands.
struct RunsRequest {
  std::string directory;          ///< of the runs; empty: runs_directory() says which
  std::string run, other, query;  ///< runs by name, folder or "last"
  std::vector<std::string> runs;  ///< likewise
  std::vector<std::string> show;  ///< keys to show for each run
  bool json = false, keys = false;
  bool yes = false;        ///< remove them
  std::size_t newest = 0;  ///< number of runs to show; 0: all
};

struct PageRequest {
  std::string run, out;   ///< a CSV, or a kept run; out: empty: RUN.html
  std::string directory;  ///< of kept runs; empty: runs_directory() says which
  bool force = false;
};
/// Writes a run as one page for a browser.
int write_page(const PageRequest& request);

/// Each returns an ExitStatus and reports errors on stderr.
int list_runs(const RunsRequest& request);
int show_run(const RunsRequest& request);
/// `expectation_failed` if none is found.
int find_runs(const RunsRequest& request);
/// Prints the differences between two runs.
int compare_runs(const RunsRequest& request);
/// `expectation_failed` if the record does not follow from its inputs.
int verify_runs(const RunsRequest& request);

/// Prints the runs that are named or found by the query, and with `yes` removes them.
int remove_runs(const RunsRequest& request);

}  // namespace skein::app
