#pragma once

#include <string>
#include <vector>

namespace skein::app {

/// What all of `skein runs` are asked.
struct RunsRequest {
  std::string directory;          ///< of the runs; empty: runs_directory() says which
  std::string run, other, query;  ///< runs by name, folder or "last"
  std::vector<std::string> show;  ///< keys to be shown beside each run
  bool json = false, keys = false;
  std::size_t newest = 0;  ///< show so many; 0: all
};

struct PageRequest {
  std::string run, out;   ///< a CSV, or a kept run; out: empty: RUN.html
  std::string directory;  ///< of kept runs; empty: runs_directory() says which
  bool force = false;
};
/// Writes a run as one page for a browser.
int write_page(const PageRequest& request);

/// Each returns an ExitStatus and says what went wrong on stderr.
int list_runs(const RunsRequest& request);
int show_run(const RunsRequest& request);
/// `expectation_failed` where none is found.
int find_runs(const RunsRequest& request);
/// What two runs do not have in common.
int compare_runs(const RunsRequest& request);
/// `expectation_failed` where the record does not follow from its inputs.
int verify_runs(const RunsRequest& request);

}  // namespace skein::app
